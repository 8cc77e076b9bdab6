// Functions that turn text in base64, in which Python packs bytes and numbers for the pages, into these bytes and numbers.

/** Return the bytes that a text in base64 stands for. */
export function bytesIn(text) {
  const signs = atob(text);
  const bytes = new Uint8Array(signs.length);
  for (let k = 0; k < signs.length; k += 1) bytes[k] = signs.charCodeAt(k);
  return bytes;
}

/** Return the 64-bit real numbers that a text in base64 stands for, without decompression. */
export function numbersIn(text) {
  return new Float64Array(bytesIn(text).buffer);
}

/** Return the bytes that a text in base64 stands for, after decompression. */
export async function decompressed(text) {
  const stream = new Blob([bytesIn(text)]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
