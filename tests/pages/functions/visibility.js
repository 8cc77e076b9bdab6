// Functions that tests/pages/test_visibility.py runs in a page.

export const shares = async () => {
  const share = () => {
    const [from, to] = [...document.querySelectorAll(".joint")]
      .map((element) => [element.cx.baseVal.value, element.cy.baseVal.value]);
    const walls = [...document.querySelectorAll("#scene .wall")]
      .flatMap((line) => [...line.points]).map(({ x }) => x);
    return Math.hypot(to[0] - from[0], to[1] - from[1]) / (Math.max(...walls) - Math.min(...walls));
  };
  const painted = () => new Promise((resolve) => requestAnimationFrame(() => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = resolve;
    port2.postMessage(0);
  }));
  const sharesOfSizes = [share()];
  for (const width of ["70%", "40%", "90%"]) {
    document.getElementById("stage").style.width = width;
    await painted();
    sharesOfSizes.push(share());
  }
  return sharesOfSizes;
};

export const heightsAtImpacts = async () => {
  const heights = new Set();
  for (const row of document.querySelectorAll("#impacts tbody tr")) {
    row.click();
    await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
    const { scrollHeight, clientHeight } = document.getElementById("caption");
    if (scrollHeight > clientHeight + 1) throw new Error("the caption is cut");
    heights.add(document.getElementById("view").clientHeight);
  }
  return [...heights];
};

export const textsOnPoints = async () => {
  const boxes = (kind) => [...document.querySelectorAll(`#scene ${kind}`)]
    .filter((element) => element.checkVisibility({ visibilityProperty: true }))
    .map((element) => element.getBoundingClientRect());
  const meet = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 0.5 &&
    Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
  const heights = { texts: 0, met: 0 };
  for (const row of document.querySelectorAll("#impacts tbody tr")) {
    row.click();
    for (let k = 0; k < 5; k += 1) {
      await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
      const [texts, others] = [boxes(".force-text"), boxes(":is(.tip, .joint, .point-number)")];
      heights.texts += texts.length;
      heights.met += texts.filter((text) => others.some((other) => meet(text, other))).length;
      document.body.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft", bubbles: true }));
    }
  }
  return heights;
};

export const stopWorkers = () => {
  let left = 5; // messages that still pass: the scene, the present run, and three rows
  window.Worker = class extends Worker {
    postMessage(message) {
      left -= 1;
      if (left >= 0) super.postMessage(message);
    }
  };
  Object.defineProperty(navigator, "hardwareConcurrency", { value: 1 });
};

export const opaqueRows = () => {
  const canvas = document.getElementById("map-canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  return Array.from({ length: canvas.height }, (_, row) => data[4 * row * canvas.width + 3]);
};
