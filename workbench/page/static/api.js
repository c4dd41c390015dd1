// Requests to the server, and the jobs that it runs.
import { h, fill, say } from './dom.js';

async function answered(response) {
  if (response.ok) return response;
  let answer = {};
  try { answer = await response.json(); } catch { /* no JSON: the status says it */ }
  throw Object.assign(new Error(answer.error ?? `${response.status} ${response.statusText}`), { answer });
}

async function send(path, options) {
  let response;
  try {
    response = await fetch(path, options);
  } catch (error) {
    if (error.name === 'AbortError') throw error;
    throw new Error('the server does not answer; is "stagecad workbench" still running?');
  }
  return answered(response);
}

export const get = async (path) => (await send(path, {})).json();

export const post = async (path, body = {}, signal = undefined) =>
  (await send(path, { method: 'POST', headers: { 'content-type': 'application/json' }, body: JSON.stringify(body), signal })).json();

export const upload = async (path, file) =>
  (await send(path, { method: 'POST', headers: { 'content-type': 'application/octet-stream' }, body: file })).json();

/** Series of a job's curves over a window: an array of Float64Array, the first the abscissa. */
export async function curves(job, number, series, { start, stop, columns = 1200, pairs = false } = {}, signal = undefined) {
  const query = new URLSearchParams({ series: series.join(','), columns: String(columns), pairs: String(pairs) });
  if (start !== undefined && start !== null) query.set('start', String(start));
  if (stop !== undefined && stop !== null) query.set('stop', String(stop));
  const response = await send(`/api/jobs/${job}/curves/${number}?${query}`, { signal });
  const values = new Float64Array(await response.arrayBuffer());
  const rows = Number(response.headers.get('x-rows'));
  const length = values.length / rows;
  return Array.from({ length: rows }, (_, k) => values.subarray(k * length, (k + 1) * length));
}

export const jobs = new Map();
const listeners = new Set();
const waiting = new Map();
const FINISHED = new Set(['done', 'failed', 'cancelled']);

/** Call `f` with each job that changes. */
export const onJob = (f) => listeners.add(f);

function take(job) {
  const known = jobs.get(job.number);
  if (known && FINISHED.has(known.state) && !FINISHED.has(job.state)) return;
  jobs.set(job.number, job);
  for (const f of listeners) f(job);
  if (FINISHED.has(job.state)) {
    for (const settle of waiting.get(job.number) ?? []) settle(job);
    waiting.delete(job.number);
  }
  showJobs();
}

/** The result of a job, once it is done; rejects when it fails or is cancelled. */
export async function result(job) {
  let last = jobs.get(job.number) ?? job;
  take(last);
  if (!FINISHED.has(last.state)) {
    last = await new Promise((settle) => waiting.set(job.number, [...(waiting.get(job.number) ?? []), settle]));
  }
  if (last.state === 'cancelled') throw Object.assign(new Error(last.error || 'cancelled'), { name: 'Cancelled' });
  if (last.state === 'failed') throw new Error(last.error);
  return get(`/api/jobs/${job.number}/result`);
}

export const cancel = (job) => post(`/api/jobs/${job.number}/cancel`).then(take);

/** Read all jobs and listen to their changes; again after the connection was lost. */
export async function listen() {
  const refresh = async () => {
    const present = await get('/api/jobs');
    const numbers = new Set(present.map((job) => job.number));
    // Those that a former server was working on have ended with it, and the present one gives their numbers again.
    for (const job of [...jobs.values()]) {
      if (numbers.has(job.number)) continue;
      if (!FINISHED.has(job.state)) take({ ...job, state: 'cancelled', error: 'the server ended' });
      jobs.delete(job.number);
    }
    for (const job of present) take(job);
  };
  const source = new EventSource('/api/events');
  source.onmessage = (event) => take(JSON.parse(event.data));
  let lost = false;
  source.onerror = () => { lost = true; say('connection to the server lost', 'bad'); };
  source.onopen = () => { if (lost) { lost = false; say('connected again'); refresh().then(() => dispatchEvent(new Event('reconnected'))).catch((error) => say(error.message, 'bad')); } };
  await refresh();
}

let shown = { numbers: '', lines: [] };

function showJobs() {
  const active = [...jobs.values()].filter((job) => !job.passing && !FINISHED.has(job.state));
  const numbers = active.map((job) => job.number).join();
  if (numbers !== shown.numbers) {
    // The elements of a job stay while it works: a button that is made anew at each step cannot be clicked.
    shown = { numbers, lines: active.map((job) => ({ step: h('span', { class: 'step' }), bar: h('progress', { 'aria-label': job.title }) })) };
    fill(document.getElementById('jobs'), active.map((job, k) => h('span', { class: 'job' },
      h('b', {}, `${job.title} ${job.subject}`.trim()), shown.lines[k].step, shown.lines[k].bar,
      h('button', { class: 'icon', title: `Cancel: ${job.title}`, 'aria-label': `Cancel ${job.title}`, onclick: () => cancel(job) }, '×'))));
  }
  for (const [k, job] of active.entries()) {
    const { step, bar } = shown.lines[k];
    step.textContent = job.state === 'waiting' ? 'waiting' : `${job.step.replaceAll('_', ' ')}${job.total > 0 ? ` ${job.done}/${job.total}` : ''}`;
    if (job.total > 0) { bar.max = job.total; bar.value = job.done; } else bar.removeAttribute('value');
  }
}
