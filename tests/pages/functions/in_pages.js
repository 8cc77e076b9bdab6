// Functions that tests/pages/in_pages.py runs in a page.

export const rowsInPage = async ([chart, colour]) => {
  await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
  const style = getComputedStyle(document.documentElement).getPropertyValue(`--${colour}`);
  const wanted = style.match(/[0-9a-f]{2}/g).map((part) => parseInt(part, 16));
  const canvas = document.querySelector(`#${chart} canvas`);
  const context = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
  const rows = [];
  for (let k = 0; k < data.length; k += 4) {
    const isFound = data[k + 3] > 200 && wanted.every((part, c) => Math.abs(part - data[k + c]) < 30);
    if (isFound) rows.push(Math.floor(k / 4 / canvas.width));
  }
  return rows;
};

export const textsOf = (arrays) => arrays.map((array) => {
  const bytes = new Uint8Array(array.buffer);
  let signs = "";
  for (let k = 0; k < bytes.length; k += 4096) signs += String.fromCharCode(...bytes.subarray(k, k + 4096));
  return btoa(signs);
});
