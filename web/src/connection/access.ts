// SPDX-License-Identifier: MIT
// The key to the studio. The address that the studio prints has a token, which is exchanged for the
// key once. The browser stores the key under this page's origin and port, for other windows and for
// reloads. The key is invalid once the studio has ended.
const KEPT = "kibori-key";

let given = ""; // used if the browser stores nothing
let refused = false;

/** The latest key that any window of this browser received; empty: none. */
export function key(): string {
  try {
    return localStorage.getItem(KEPT) ?? given;
  } catch {
    return given;
  }
}

/** Like fetch, but sends the key. */
export const request = (path: string, how: RequestInit = {}): Promise<Response> =>
  fetch(path, { ...how, headers: { Authorization: `Bearer ${key()}` } });

/** Resolves when the token of the address, if there is one, has been exchanged. */
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
    // Then the key is lost when this window is reloaded.
  }
}

/** Message: what to do if the studio rejects the key. */
export function whyRefused(): string {
  if (refused)
    return "An address opens the studio once, in one browser: open the newest one in the terminal.";
  if (key()) return "The studio was started anew: open the address it printed in the terminal.";
  return "This window does not have the key to the studio: open the address it printed in the terminal.";
}
