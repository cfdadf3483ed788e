// Writes an image to the drive that a Pico shows while BOOTSEL is held: a file of UF2 blocks.

const MAGIC = [0x0a324655, 0x9e5d5157, 0x0ab16f30];
/** The flag of a block with a family, and the family of the RP2040. */
const [FAMILY, RP2040] = [0x2000, 0xe48bff56];
const BY_HAND = "hold BOOTSEL while you plug the Pico in, and copy the .uf2 file to the drive RPI-RP2 that appears.";

/** What is wrong with a file of UF2 blocks for an RP2040; empty if nothing is. */
export function wrongUf2(bytes) {
  const count = bytes.length / 512;
  if (!count || count % 1) return "This is no .uf2 file: its length is not a number of blocks of 512 bytes.";
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  for (let block = 0; block < count; block += 1) {
    const word = (at) => view.getUint32(512 * block + at, true);
    const [first, second, last] = [0, 4, 508].map(word);
    if (first !== MAGIC[0] || second !== MAGIC[1] || last !== MAGIC[2]) return `Block ${block} of this file is no UF2 block.`;
    if (!(word(8) & FAMILY) || word(28) !== RP2040) return "This file is for another chip than the Pico's, an RP2040.";
    if (word(16) !== 256 || word(20) !== block || word(24) !== count) return `Block ${block} of ${count} is out of its place: the file is not whole.`;
  }
  return "";
}

/** Writes a file to a drive that the user chooses; gives what came of it, in a sentence. */
export async function write(file) {
  if (!window.showDirectoryPicker) return `This browser cannot write to a drive: ${BY_HAND}`;
  const bytes = new Uint8Array(await file.arrayBuffer());
  const wrong = wrongUf2(bytes);
  if (wrong) return wrong;
  let drive;
  try {
    drive = await window.showDirectoryPicker({ id: "pico", mode: "readwrite" });
  } catch (error) {
    return error.name === "AbortError" ? "No drive was chosen." : `The browser refuses this drive: ${BY_HAND}`;
  }
  try {
    const info = await (await drive.getFileHandle("INFO_UF2.TXT")).getFile();
    // A drive's own file is short.
    if (info.size > 4096 || !/RPI-RP2\b/.test(await info.text())) return "This drive belongs to another board than a Pico.";
  } catch {
    return `This is no Pico's drive: it has no INFO_UF2.TXT. To see one, ${BY_HAND}`;
  }
  let stream;
  try {
    stream = await (await drive.getFileHandle("picket-pico.uf2", { create: true })).createWritable();
    await stream.write(bytes);
  } catch (error) {
    await stream?.abort().catch(() => {});
    return `Writing failed: ${error.message} By hand: ${BY_HAND}`;
  }
  // The board restarts with the last block, and its drive goes away before the browser closes the file.
  const closed = await stream.close().then(() => true, () => false);
  const size = `${bytes.length / 1024} KB are written`;
  return closed ? `${size}: the board restarts, and its drive disappears. Then connect.` : `${size}, and the drive went away, as it does when the board restarts. Then connect.`;
}
