// Requests to the server of this page.

/** The server requires a token. */
export class TokenRequired extends Error {}

let token = sessionStorage.getItem("token");

/** Stores the token until the tab closes. */
export function unlock(text) {
  token = text;
  sessionStorage.setItem("token", text);
}

/** Sends a request without parameters that are null, and returns the document. */
export async function request(path, parameters = {}) {
  const query = new URLSearchParams(Object.entries(parameters).filter(([, value]) => value != null && value !== ""));
  const headers = token ? { Authorization: `Bearer ${token}` } : {};
  let response;
  try {
    // Without the browser's cache, which is slower than the server.
    response = await fetch(`${path}?${query}`, { headers, cache: "no-store" });
  } catch {
    throw new Error("No response from the server; check that streakcast serve is running.");
  }
  const type = response.headers.get("Content-Type") ?? "";
  const document = type.includes("json") ? await response.json() : {};
  if (response.status === 401) throw new TokenRequired(document.detail);
  if (!response.ok) throw new Error(document.detail ?? `The server responded with status ${response.status}.`);
  return document;
}

/** Sends one request at a time, and then only the latest waiting one, so that the page does not lag behind a drag. */
export function latest(path, answered, failed) {
  let busy = false;
  let waiting = null;
  async function next() {
    busy = true;
    while (waiting) {
      const parameters = waiting;
      waiting = null;
      try {
        answered(await request(path, parameters), parameters);
      } catch (error) {
        if (!waiting) failed(error, parameters);
      }
    }
    busy = false;
  }
  return (parameters) => {
    waiting = parameters;
    if (!busy) next();
  };
}
