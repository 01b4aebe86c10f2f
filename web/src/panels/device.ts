// SPDX-License-Identifier: MIT
// The panel of the force device: its name, the switch of its force, and the scale from its hand to
// the tool.
import { element, input, put, read } from "../base/dom";
import { write, type Device } from "../connection/messages";

const STATES = [
  "Off: it gives no force.",
  "Waiting: move it clear of the wood.",
  "On: it gives the force.",
];

export class DevicePanel {
  /** Share of the wood's force that the device gives to the hand; 0: no device. */
  share = 0;
  private there = false;
  private armed = false;

  constructor(send: (message: Uint8Array) => void) {
    element("arm").onclick = () => send(write.Arm({ armed: this.armed ? 0 : 1 }));
    input("reach").oninput = () =>
      send(write.ChooseReach({ scale: 10 ** Number(input("reach").value) }));
  }

  /** Resets for another document. There is no device until the studio reports one. */
  begin(): void {
    this.there = false;
    this.share = 0;
    element("device").hidden = true;
    document.body.classList.remove("device");
  }

  show(d: Device): void {
    this.there = true;
    document.body.classList.add("device");
    element("hint").hidden = true;
    element("device").hidden = false;
    element("device-name").textContent =
      d.force > 0 ? `${d.name}: at most ${d.force.toPrecision(2)} N` : `${d.name}: gives no force`;
    element("arm").hidden = d.force === 0;
    input("reach").value = String(Math.log10(d.scale));
    element("reach-out").textContent = `${d.scale.toPrecision(2)} ×`;
    this.share = d.force > 0 ? d.share : 0;
    input("stiffness").max = d.max.toPrecision(3);
    input("stiffness").placeholder = d.stiffness.toPrecision(2);
  }

  showState(safety: number, trip: string, given: number): void {
    if (!this.there) return;
    this.armed = safety !== 0;
    put("arm", this.armed ? "Stop the force" : "Let it push");
    put("device-state", STATES[safety] + (trip ? ` ${trip}` : ""));
    read("device-given", safety === 2 ? `${given.toFixed(2)} N given` : "");
  }
}
