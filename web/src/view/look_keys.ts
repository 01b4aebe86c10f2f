// SPDX-License-Identifier: MIT
// Keys of the view: arrows turn the piece, or move it with Shift. Plus and minus zoom.
import * as THREE from "three";
import type { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const TURN_RAD = Math.PI / 24;
const MOVE = 0.08; // share of the window's height
const NEARER = 1 / 1.15;
const STEEPEST = 0.02; // min angle from looking straight down [rad]

const WAYS: Record<string, [number, number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

export function lookByKeys(canvas: HTMLElement, controls: OrbitControls): void {
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !controls.enabled) return;
    // The active camera.
    const camera = controls.object as THREE.PerspectiveCamera | THREE.OrthographicCamera;
    const eye = camera.position,
      from = eye.clone().sub(controls.target),
      way = WAYS[event.key];
    if (!way && !["+", "=", "-"].includes(event.key)) return;
    event.preventDefault();
    controls.dispatchEvent({ type: "start" }); // stops other rotations of the camera
    if (way && event.shiftKey) {
      const right = new THREE.Vector3().setFromMatrixColumn(camera.matrix, 0),
        up = new THREE.Vector3().setFromMatrixColumn(camera.matrix, 1);
      // The sixth number of a projection matrix is 2 / height of the view; in perspective, at
      // distance 1.
      const high = 2 / camera.projectionMatrix.elements[5],
        far = camera instanceof THREE.OrthographicCamera ? 1 : from.length();
      const by = right
        .multiplyScalar(-way[0])
        .addScaledVector(up, -way[1])
        .multiplyScalar(MOVE * high * far);
      eye.add(by);
      controls.target.add(by);
    } else if (way) {
      // The piece turns in the direction of the arrow.
      const distance = from.length(),
        around = Math.atan2(from.y, from.x) - TURN_RAD * way[0];
      const down = Math.max(
        STEEPEST,
        Math.min(Math.PI - STEEPEST, Math.acos(from.z / distance) - TURN_RAD * way[1]),
      );
      eye
        .copy(controls.target)
        .add(
          new THREE.Vector3(
            Math.sin(down) * Math.cos(around),
            Math.sin(down) * Math.sin(around),
            Math.cos(down),
          ).multiplyScalar(distance),
        );
    } else {
      const factor = event.key === "-" ? 1 / NEARER : NEARER;
      if (camera instanceof THREE.OrthographicCamera) {
        camera.zoom /= factor;
        camera.updateProjectionMatrix();
        controls.dispatchEvent({ type: "change" }); // update() fires no event for a changed zoom
      } else eye.copy(controls.target).addScaledVector(from, factor);
    }
    controls.update();
  });
}
