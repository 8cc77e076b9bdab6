// What `packed` of `explore.py` made, as bytes, and numbers in base64.

/** The bytes of a text in base64. */
function bytesIn(text) {
  return Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
}

/** The numbers of such a text, which is not compressed. */
export function numbersIn(text) {
  return new Float64Array(bytesIn(text).buffer);
}

/** The bytes of a text that is compressed. */
export async function unpacked(text) {
  const stream = new Blob([bytesIn(text)]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
