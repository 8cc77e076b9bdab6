// Functions that tests/pages/test_compared_motions.py runs in a page.

export const outside = () => {
  const { width, height } = document.getElementById("scene").getBoundingClientRect();
  return [...document.querySelectorAll("polyline.compared, polyline.link")]
    .flatMap((line) => [...line.points])
    .filter(({ x, y }) => x < 0 || y < 0 || x > width || y > height).length;
};

export const letters = async () => {
  const [lettersOfCharts, write] = [{}, CanvasRenderingContext2D.prototype.fillText];
  CanvasRenderingContext2D.prototype.fillText = function (text, ...at) {
    const chart = this.canvas.closest(".chart").id;
    if (/^[A-E]$/.test(text)) lettersOfCharts[chart] = [...new Set([...(lettersOfCharts[chart] ?? []), text])];
    return write.call(this, text, ...at);
  };
  document.querySelectorAll(".chart").forEach((chart) => { chart.style.width = "300px"; });
  await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
  return lettersOfCharts;
};
