// Functions that tests/pages/test_visibility.py runs in a page.

export const shares = async () => {
  const share = () => {
    const [from, to] = [...document.querySelectorAll(".joint")]
      .map((one) => [one.cx.baseVal.value, one.cy.baseVal.value]);
    const walls = [...document.querySelectorAll("#scene .wall")]
      .flatMap((line) => [...line.points]).map(({ x }) => x);
    return Math.hypot(to[0] - from[0], to[1] - from[1]) / (Math.max(...walls) - Math.min(...walls));
  };
  const painted = () => new Promise((done) => requestAnimationFrame(() => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = done;
    port2.postMessage(0);
  }));
  const found = [share()];
  for (const width of ["70%", "40%", "90%"]) {
    document.getElementById("stage").style.width = width;
    await painted();
    found.push(share());
  }
  return found;
};
