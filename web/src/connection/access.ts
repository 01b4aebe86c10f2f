// SPDX-License-Identifier: MIT
// The key to the studio. The address that it printed has a token, which is exchanged for the key
// once. The key is kept by this page's origin, port included, for other windows and for reloading;
// it is of no use once the studio has ended.
const KEPT = "kibori-key";

let given = ""; // where the browser keeps nothing
let refused = false;

/** The key, as any window of this browser got it last; empty: there is none. */
export function key(): string {
  try {
    return localStorage.getItem(KEPT) ?? given;
  } catch {
    return given;
  }
}

/** As fetch, with the key. */
export const request = (path: string, how: RequestInit = {}): Promise<Response> =>
  fetch(path, { ...how, headers: { Authorization: `Bearer ${key()}` } });

/** Done when the token of the address, if there is one, was exchanged. */
export const entered = enter();

async function enter(): Promise<void> {
  const token = new URLSearchParams(location.search).get("token");
  if (token === null) return;
  history.replaceState(null, "", "/");
  const answer = await request(`/enter?token=${encodeURIComponent(token)}`, {
    method: "POST",
  }).catch(() => null);
  refused = answer?.status === 403;
  if (!answer?.ok) return;
  given = await answer.text();
  try {
    localStorage.setItem(KEPT, given);
  } catch {
    // Until this window is reloaded, then.
  }
}

/** What to do where the studio does not take the key. */
export function whyRefused(): string {
  if (refused)
    return "An address opens the studio once, in one browser: open the newest one in the terminal.";
  if (key()) return "The studio was started anew: open the address it printed in the terminal.";
  return "This window does not have the key to the studio: open the address it printed in the terminal.";
}
