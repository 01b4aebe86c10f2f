// SPDX-License-Identifier: MIT
// Places the popovers of the fixed bar next to their buttons, inside the window.

const MARGIN_PX = 8;

/** Connects all popovers of the page. */
export function placePopovers(): void {
  for (const pop of document.querySelectorAll<HTMLElement>("[popover]")) {
    const button = document.querySelector<HTMLElement>(`[popovertarget="${pop.id}"]`);
    const place = (): void => {
      if (!button || !pop.matches(":popover-open")) return;
      const at = button.getBoundingClientRect(),
        { width, height } = pop.getBoundingClientRect();
      const within = (x: number, max: number): number => Math.max(MARGIN_PX, Math.min(x, max));
      pop.style.left = `${within(at.left, innerWidth - width - MARGIN_PX)}px`;
      pop.style.top = `${within(at.bottom + 4, innerHeight - height - MARGIN_PX)}px`;
    };
    pop.addEventListener("toggle", place);
    new ResizeObserver(place).observe(pop);
    window.addEventListener("resize", place);
  }
}

/** Closes the open popover. Returns whether there was one. */
export function closePopover(): boolean {
  const open = document.querySelector<HTMLElement>("[popover]:popover-open");
  open?.hidePopover();
  return open !== null;
}
