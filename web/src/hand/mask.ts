// SPDX-License-Identifier: MIT
// The controls of the mask brush. What is masked does not move. A button changes the mask of the
// whole piece: it makes a stroke of one dab that reaches everything.
import * as THREE from "three";
import { element, input, select } from "../base/dom";
import type { Vec3 } from "../base/vec3";
import { MASK_VERBS, type MaskVerb } from "../connection/kinds";
import type { Hit } from "../view/pick";
import { write } from "../connection/messages";

/** What each button does: a verb, and a negative strength for its opposite. */
const BUTTONS: Record<string, { verb: MaskVerb; strength: number }> = {
  clear: { verb: "paint", strength: -1 },
  invert: { verb: "invert", strength: 1 },
  soften: { verb: "blur", strength: 1 },
  sharpen: { verb: "blur", strength: -1 },
  hollows: { verb: "cavity", strength: 1 },
  ridges: { verb: "cavity", strength: -1 },
  above: { verb: "height", strength: 1 },
  material: { verb: "material", strength: 1 },
};

/** The fields of a ChooseBrush message that concern masks. */
export interface MaskFields {
  mask: number;
  mask_material: number;
}

export class MaskControls {
  constructor(
    private send: (message: Uint8Array) => void,
    private parts: {
      /** The bounds of the piece. */
      bounds: () => THREE.Box3;
      /** The plane that the user has set. */
      plane: () => Hit | null;
      /** Sends the brush that the user has chosen again. */
      restore: () => void;
      /** Draws what is masked, or hides it. */
      hide: (hides: boolean) => void;
    },
  ) {
    select("mask-verb").addEventListener("change", () => parts.restore());
    element("masks").addEventListener("click", (event) => {
      const { mask } = (event.target as HTMLElement).dataset;
      if (mask) this.act(mask);
    });
    input("hide-masked").addEventListener("change", () => parts.hide(input("hide-masked").checked));
  }

  /** The fields for the user's own strokes. */
  fields(): MaskFields {
    return {
      mask: MASK_VERBS.indexOf(select("mask-verb").value as MaskVerb),
      mask_material: Number(select("material").value) || 0,
    };
  }
  /** Shows the button that needs a plane if there is one. */
  show(): void {
    element("masks").querySelector<HTMLElement>("[data-mask=above]")!.hidden =
      this.parts.plane() === null;
  }

  /** Changes the mask of the whole piece. */
  private act(name: string): void {
    const { verb, strength } = BUTTONS[name],
      plane = this.parts.plane(),
      bounds = this.parts.bounds();
    this.send(
      write.ChooseBrush({
        radius: bounds.getSize(new THREE.Vector3()).length(),
        strength,
        falloff: 2,
        keep: 0,
        red: 0,
        green: 0,
        blue: 0,
        plane: verb === "height" ? 2 : 1,
        point: plane ? (plane.point.toArray() as Vec3) : [0, 0, 0],
        normal: plane ? (plane.normal.toArray() as Vec3) : [0, 0, 1],
        wall: 0,
        mask: MASK_VERBS.indexOf(verb),
        mask_material: this.fields().mask_material,
        alpha: 0,
        pressure: 0,
      }),
    );
    this.send(
      write.Press({
        tip: bounds.getCenter(new THREE.Vector3()).toArray() as Vec3,
        axis: [0, 0, 1],
        mode: "mask",
        time: performance.now() / 1000,
        pressure: 1,
      }),
    );
    this.send(write.Lift());
    this.parts.restore();
  }
}
