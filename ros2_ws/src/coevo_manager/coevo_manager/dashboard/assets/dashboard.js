'use strict';

/* What all pages of the dashboard share: which one is shown, and the stream of news of runs. */

const runs = new Map();
const listeners = [];

function shownPage() {
  const name = location.hash.slice(1);
  return document.querySelector(`[data-page]#${CSS.escape(name || 'runs')}`) ? name || 'runs' : 'runs';
}

function showPage() {
  const shown = shownPage();
  for (const page of document.querySelectorAll('[data-page]')) page.hidden = page.id !== shown;
  for (const link of document.querySelectorAll('nav a')) {
    link.ariaCurrent = link.hash === `#${shown}` ? 'page' : null;
  }
  document.dispatchEvent(new Event('page'));
  window.dispatchEvent(new Event('resize')); // charts that were hidden take the width there is
}

/* JSON that the server answers; an Error whose text says what is wrong otherwise. */
async function answer(address, options = {}) {
  let response;
  try {
    response = await fetch(address, options);
  } catch {
    throw new Error('the dashboard has ended or cannot be reached');
  }
  const content = await response.json().catch(() => ({}));
  if (!response.ok) throw new Error(content.problem || `the dashboard answered ${response.status}`);
  return content;
}

/* A stream of the server, which the browser asks for again when it breaks off. */
function listenTo(address, take) {
  const source = new EventSource(address);
  const connection = document.getElementById('connection');
  source.addEventListener('message', (event) => {
    connection.hidden = true;
    take(JSON.parse(event.data));
  });
  source.addEventListener('error', () => { connection.hidden = false; });
  return source;
}

/* An element with a class, attributes and content. */
function element(tag, { className = '', ...attributes } = {}, ...content) {
  const made = document.createElement(tag);
  made.className = className;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...content);
  return made;
}

window.addEventListener('hashchange', showPage);
window.addEventListener('DOMContentLoaded', () => {
  showPage();
  listenTo('/events', ({ runs: news, keys, problems }) => {
    for (const key of runs.keys()) if (!keys.includes(key)) runs.delete(key);
    for (const run of news) runs.set(run.key, run);
    const unreadable = document.getElementById('unreadable');
    unreadable.textContent = problems.join('\n');
    unreadable.hidden = !problems.length;
    for (const listener of listeners) listener();
  });
});
