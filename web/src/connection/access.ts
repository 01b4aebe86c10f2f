// SPDX-License-Identifier: MIT
// The key to the studio. The printed address contains a token, which the page exchanges once for
// the key. The browser keeps the key for this origin, port included, so that other windows and
// reloads can use it. The key is useless after the studio ends.
//
// A device of the network has no key. It has a session cookie, which the browser sends by itself.
import { t } from "../base/texts";

/** True if the studio serves this page to a device of the network. */
export const overNetwork = location.protocol === "https:";

const KEPT = "kibori-key";

let given = ""; // used if the browser has no storage
let refused = false;

/** The newest key that any window of this browser received. Empty if there is none. */
export function key(): string {
  try {
    return localStorage.getItem(KEPT) ?? given;
  } catch {
    return given;
  }
}

/** Like fetch, with the key in the Authorization header. */
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
    // The key then lasts until this window is reloaded.
  }
}

/** A message for the user if the studio refuses the key. */
export function whyRefused(): string {
  if (refused) return t("address_used");
  if (key()) return t("restarted");
  return t("no_access");
}
