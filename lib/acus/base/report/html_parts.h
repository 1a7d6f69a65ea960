// The fixed parts of a report: its style sheet, and the script that reads values off the plots.
#pragma once

#include <string_view>

namespace acus::report {

/// pipelines/common/page.css: the style sheet of all pages, compiled into the library.
std::string_view StyleSheet();

// Everything that it needs stands in the plot: data-frame in pixels, data-x and data-y in values.
inline constexpr std::string_view kReadingScript = R"js(
(() => {
  const numbers = text => text.trim().split(/[\s,MhzL]+/).filter(s => s).map(Number);
  const toValue = (axis, t) => {
    const [low, high, kind] = axis.split(' ');
    if (kind !== 'log') return +low + t * (high - low);
    return Math.exp(Math.log(low) + t * (Math.log(high) - Math.log(low)));
  };
  const pointsOf = series => {
    if (series.points) return series.points;
    const path = series.querySelector('path');
    const text = path ? path.getAttribute('d') : '';
    const values = numbers(text.replaceAll('h0', ' '));
    series.points = [];
    for (let i = 0; i + 1 < values.length; i += 2) series.points.push([values[i], values[i + 1]]);
    series.isBand = text.endsWith('z');
    series.isLine = !series.isBand && !text.includes('h0');
    return series.points;
  };
  const pixelY = (series, x) => {
    const points = pointsOf(series);
    for (let i = 0; series.isLine && i + 1 < points.length; ++i) {
      const [[x0, y0], [x1, y1]] = [points[i], points[i + 1]];
      if (x0 !== x1 && (x0 - x) * (x1 - x) <= 0) return y0 + (y1 - y0) * (x - x0) / (x1 - x0);
    }
    return points.reduce(
      (best, p) => Math.abs(p[0] - x) < Math.abs(best[0] - x) ? p : best, points[0])[1];
  };
  for (const figure of document.querySelectorAll('figure')) {
    const svg = figure.querySelector('svg');
    if (!svg) continue;
    const box = document.createElement('div');
    box.className = 'reading';
    box.hidden = true;
    figure.append(box);
    svg.addEventListener('mouseleave', () => { box.hidden = true; });
    svg.addEventListener('mousemove', event => {
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(
        svg.getScreenCTM().inverse());
      box.hidden = true;
      for (const plot of svg.querySelectorAll('g.plot')) {
        const [left, top, width, height] = numbers(plot.dataset.frame);
        if (at.x < left || at.x > left + width || at.y < top || at.y > top + height) continue;
        const show = v => Number(v.toPrecision(5)).toString();
        const lines = ['x ' + show(toValue(plot.dataset.x, (at.x - left) / width))];
        for (const series of plot.querySelectorAll('g.series')) {
          const points = pointsOf(series);
          if (!points.length || series.isBand) continue;
          const y = toValue(plot.dataset.y, (top + height - pixelY(series, at.x)) / height);
          lines.push((series.dataset.name || 'y') + ' ' + show(y));
        }
        box.textContent = lines.join('\n');
        box.hidden = false;
        const frame = figure.getBoundingClientRect();
        const x = event.clientX - frame.left;
        const fits = x + box.offsetWidth + 24 < frame.width;
        box.style.left = (fits ? x + 14 : x - box.offsetWidth - 12) + 'px';
        box.style.top = (event.clientY - frame.top + 10) + 'px';
      }
    });
  }
})();
)js";

}  // namespace acus::report
