// SPDX-License-Identifier: MIT
// Checks an exported file with another program: Manifold, or Khronos' glTF validator. Usage:
// node judge.mjs manifold FILE.stl | gltf FILE.glb
// Prints one line of JSON. Exits with 1 if that program finds a fault.
import { readFileSync } from "node:fs";

const [judge, file] = process.argv.slice(2);
const bytes = readFileSync(file);

async function manifold() {
  const Module = (await import("manifold-3d")).default;
  const wasm = await Module();
  wasm.setup();
  const count = bytes.readUInt32LE(80);
  const index = new Map(),
    positions = [],
    triangles = new Uint32Array(3 * count);
  for (let i = 0; i < 3 * count; i++) {
    const at = 84 + 50 * Math.floor(i / 3) + 12 + 12 * (i % 3);
    const p = [0, 4, 8].map((k) => bytes.readFloatLE(at + k));
    const key = p.join();
    if (!index.has(key)) {
      index.set(key, index.size);
      positions.push(...p);
    }
    triangles[i] = index.get(key);
  }
  const mesh = new wasm.Mesh({
    numProp: 3,
    vertProperties: new Float32Array(positions),
    triVerts: triangles,
  });
  const solid = new wasm.Manifold(mesh); // throws if the mesh is not a manifold
  const volume = solid.volume ? solid.volume() : solid.getProperties().volume;
  console.log(JSON.stringify({ triangles: solid.numTri(), volume, genus: solid.genus() }));
}

async function gltf() {
  const validator = (await import("gltf-validator")).default;
  const { issues, info } = await validator.validateBytes(new Uint8Array(bytes));
  const found = issues.numErrors + issues.numWarnings + issues.numInfos + issues.numHints;
  console.log(
    JSON.stringify({
      issues: found,
      messages: issues.messages.slice(0, 3),
      triangles: info.totalTriangleCount,
    }),
  );
  process.exit(found ? 1 : 0);
}

try {
  await { manifold, gltf }[judge]();
} catch (error) {
  console.log(JSON.stringify({ error: String(error.message ?? error) }));
  process.exit(1);
}
