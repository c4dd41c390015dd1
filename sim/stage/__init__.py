"""The whole stage driven by its piezos: tip, contact, stage on its pads, sensors and the loop around them."""
