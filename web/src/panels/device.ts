// SPDX-License-Identifier: MIT
// The panel of the force device: its name, the switch for the force, the reach and the stiffness.
import { t } from "../base/texts";
import { element, input, put, read } from "../base/dom";
import { write, type Device } from "../connection/messages";

const STATES = [t("device_off"), t("device_waiting"), t("device_on")];

export class DevicePanel {
  /** The share of the wood's force that the device's hand receives. 0: there is no device. */
  share = 0;
  private there = false;
  private armed = false;

  constructor(send: (message: Uint8Array) => void) {
    element("arm").onclick = () => send(write.Arm({ armed: this.armed ? 0 : 1 }));
    input("reach").oninput = () =>
      send(write.ChooseReach({ scale: 10 ** Number(input("reach").value) }));
  }

  /** Starts with another document. There is no device until the studio reports one. */
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
      d.force > 0
        ? t("device_force", { device: d.name, max: d.force.toPrecision(2) })
        : t("device_no_force", { device: d.name });
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
    put("arm", t(this.armed ? "stop_the_force" : "turn_the_force_on"));
    put("device-state", STATES[safety] + (trip ? ` ${trip}` : ""));
    read("device-given", safety === 2 ? t("device_given", { force: given.toFixed(2) }) : "");
  }
}
