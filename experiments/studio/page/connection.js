// SPDX-License-Identifier: BSD-3-Clause
// The studio's server, as the page asks it. Addresses count from the page's own, which carries the token.

async function answered(response) {
  const body = await response.json().catch(() => ({ error: `the studio answered with status ${response.status}` }));
  if (!response.ok) throw new Error(body.error ?? `the studio answered with status ${response.status}`);
  return body;
}

export const ask = (name) => fetch(`api/${name}`).then(answered);
export const tell = (name, body = null) =>
  fetch(`api/${name}`, { method: 'POST', body: JSON.stringify(body), headers: { 'Content-Type': 'application/json' } }).then(answered);
export const send = (file) =>
  fetch(`api/file?name=${encodeURIComponent(file.name)}`, { method: 'POST', body: file,
    headers: { 'Content-Type': 'application/octet-stream' } }).then(answered);

// Calls onState with the state whenever it is another, onLost with whether the connection is lost; goes on for ever.
export function listen(onState, onLost) {
  let source = null;
  const open = () => {
    source = new EventSource('api/events');
    source.onopen = () => onLost(false);
    source.onmessage = (event) => onState(JSON.parse(event.data));
    source.onerror = () => {
      onLost(true);
      source.close();
      setTimeout(open, 1000);
    };
  };
  open();
}
