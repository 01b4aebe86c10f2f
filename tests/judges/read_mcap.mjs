// SPDX-License-Identifier: MIT
// Prints an MCAP file as @mcap/core reads it by its index: metadata, then one line per message.
// Usage: read_mcap.mjs FILE
import { open } from "node:fs/promises";
import { McapIndexedReader } from "@mcap/core";

const file = await open(process.argv[2], "r");
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, length) => {
    const bytes = new Uint8Array(Number(length));
    const { bytesRead } = await file.read(bytes, 0, Number(length), Number(offset));
    if (bytesRead !== bytes.length) throw new Error("the file is too short");
    return bytes;
  },
};
const reader = await McapIndexedReader.Initialize({ readable });
const metadata = {};
for await (const record of reader.readMetadata())
  metadata[record.name] = Object.fromEntries(record.metadata);
const lines = [JSON.stringify({ metadata, messages: Number(reader.statistics.messageCount) })];
for await (const message of reader.readMessages({ validateCrcs: true })) {
  const { topic } = reader.channelsById.get(message.channelId);
  lines.push(
    JSON.stringify({
      topic,
      time_ns: Number(message.logTime),
      ...JSON.parse(new TextDecoder().decode(message.data)),
    }),
  );
}
await file.close();
process.stdout.write(`${lines.join("\n")}\n`);
