// Questions to the server that gave this page, and to nobody else.

/** The server asks for a token. */
export class Locked extends Error {}

let token = sessionStorage.getItem("token");

/** Remembers the token until the tab closes. */
export function unlock(text) {
  token = text;
  sessionStorage.setItem("token", text);
}

/** One question: what is null is not said. Answers with the document and what it took the server, ms. */
export async function ask(path, said = {}) {
  const query = new URLSearchParams(Object.entries(said).filter(([, value]) => value != null && value !== ""));
  const headers = token ? { Authorization: `Bearer ${token}` } : {};
  let response;
  try {
    // Past the browser's cache, which takes longer to ask than the server.
    response = await fetch(`${path}?${query}`, { headers, cache: "no-store" });
  } catch {
    throw new Error("The server does not answer. Is streakcast serve still running?");
  }
  const type = response.headers.get("Content-Type") ?? "";
  const document = type.includes("json") ? await response.json() : {};
  if (response.status === 401) throw new Locked(document.detail);
  if (!response.ok) throw new Error(document.detail ?? `The server answers ${response.status}.`);
  const timing = /dur=([\d.]+)/.exec(response.headers.get("Server-Timing") ?? "");
  return { document, ms: timing ? Number(timing[1]) : null };
}

/** Asks one question at a time; of those that come meanwhile only the last is asked, so that a drag never runs behind. */
export function line(path, answered, failed) {
  let busy = false;
  let waiting = null;
  async function next() {
    busy = true;
    while (waiting) {
      const said = waiting;
      waiting = null;
      try {
        answered(await ask(path, said), said);
      } catch (error) {
        if (!waiting) failed(error, said);
      }
    }
    busy = false;
  }
  return (said) => {
    waiting = said;
    if (!busy) next();
  };
}
