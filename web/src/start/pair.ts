// SPDX-License-Identifier: MIT
// The page that a device of the network sees first. It sends the code that the terminal shows, and
// the studio answers with a session cookie.
import "../style.css";
import { fillTexts, t, type TextKey } from "../base/texts";

const ANSWERS: Readonly<Record<number, TextKey>> = { 403: "pair_wrong", 410: "pair_expired" };

fillTexts(document.body);
const code = document.querySelector<HTMLInputElement>("#code")!;
const answer = document.querySelector<HTMLElement>("#pair-answer")!;

/** Why the studio refused the code. */
function whyNot(response: Response | null): string {
  if (!response) return t("gone");
  if (response.status === 429)
    return t("pair_wait", { seconds: response.headers.get("Retry-After") ?? 60 });
  return t(ANSWERS[response.status] ?? "gone");
}

document.querySelector("#pair")!.addEventListener("submit", (event) => {
  event.preventDefault();
  answer.textContent = "";
  const path = `/pair?code=${encodeURIComponent(code.value)}`;
  void fetch(path, { method: "POST" })
    .catch(() => null)
    .then((response) => {
      if (response?.ok) return location.reload();
      answer.textContent = whyNot(response);
      code.select();
      code.focus();
    });
});
