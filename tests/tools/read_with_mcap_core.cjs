// Reads a recording with @mcap/core, indexed and as a stream with its checksums, and decodes every message with
// @foxglove/omgidl-*. Prints the counts as JSON. Exit status 77 when the packages are not installed (NODE_PATH).
let core, nodejs, idl, cdr, fzstd;
try {
  core = require("@mcap/core");
  nodejs = require("@mcap/nodejs");
  idl = require("@foxglove/omgidl-parser");
  cdr = require("@foxglove/omgidl-serialization");
  fzstd = require("fzstd");
} catch (error) {
  console.error(`skipped: ${error.message.split("\n")[0]}`);
  process.exit(77);
}
const fs = require("node:fs");
const decompressHandlers = { zstd: (data, size) => fzstd.decompress(data, new Uint8Array(Number(size))) };

async function main(path) {
  const file = await fs.promises.open(path);
  const indexed = await core.McapIndexedReader.Initialize({ readable: new nodejs.FileHandleReadable(file), decompressHandlers });
  const readers = new Map();
  const counts = {};
  for await (const message of indexed.readMessages()) {
    const channel = indexed.channelsById.get(message.channelId);
    const schema = indexed.schemasById.get(channel.schemaId);
    if (channel.messageEncoding !== "cdr" || schema.encoding !== "omgidl") throw new Error(`${channel.topic}: not cdr with omgidl`);
    if (!readers.has(channel.id))
      readers.set(channel.id, new cdr.MessageReader(schema.name, idl.parseIDL(new TextDecoder().decode(schema.data))));
    const value = readers.get(channel.id).readMessage(message.data);
    if (value.header.version !== 1) throw new Error(`${channel.topic}: version ${value.header.version}`);
    counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
  }
  await file.close();

  let streamed = 0;
  const stream = new core.McapStreamReader({ decompressHandlers, validateCrcs: true });
  stream.append(fs.readFileSync(path));
  for (let record; (record = stream.nextRecord()); ) streamed += record.type === "Message" ? 1 : 0;
  if (!stream.done()) throw new Error("the stream has no end");
  const total = Object.values(counts).reduce((a, b) => a + b, 0);
  if (streamed !== total || BigInt(total) !== indexed.statistics.messageCount) throw new Error(`${streamed} streamed, ${total} indexed`);
  console.log(JSON.stringify({ messages: total, counts }));
}

main(process.argv[2]).catch((error) => {
  console.error(`read_with_mcap_core: ${error.message}`);
  process.exit(1);
});
