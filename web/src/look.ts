// SPDX-License-Identifier: MIT
// Looking by keys: the arrows turn the piece, with Shift they move it; plus and minus go nearer and farther.
import * as THREE from "three";
import type { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const TURN_RAD = Math.PI / 24;
const MOVE = 0.05; // of the distance
const NEARER = 1 / 1.15;
const STEEPEST = 0.02; // radians from looking straight down

const WAYS: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export function lookByKeys(canvas: HTMLElement, controls: OrbitControls): void {
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const eye = controls.object.position, from = eye.clone().sub(controls.target);
    const way = WAYS[event.key];
    if (way && event.shiftKey) {
      const right = new THREE.Vector3().setFromMatrixColumn(controls.object.matrix, 0), up = new THREE.Vector3().setFromMatrixColumn(controls.object.matrix, 1);
      const by = right.multiplyScalar(-way[0]).addScaledVector(up, -way[1]).multiplyScalar(MOVE * from.length());
      eye.add(by);
      controls.target.add(by);
    } else if (way) {
      // The piece turns the way of the arrow.
      const distance = from.length(), around = Math.atan2(from.y, from.x) - TURN_RAD * way[0];
      const down = Math.max(STEEPEST, Math.min(Math.PI - STEEPEST, Math.acos(from.z / distance) - TURN_RAD * way[1]));
      eye.copy(controls.target).add(new THREE.Vector3(Math.sin(down) * Math.cos(around), Math.sin(down) * Math.sin(around), Math.cos(down)).multiplyScalar(distance));
    } else if (["+", "=", "-"].includes(event.key)) {
      eye.copy(controls.target).addScaledVector(from, event.key === "-" ? 1 / NEARER : NEARER);
    } else {
      return;
    }
    event.preventDefault();
    controls.update();
  });
}
