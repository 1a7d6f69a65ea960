// The fixed parts of a report: its style sheet, and the script that reads values off the plots.
#pragma once

#include <string_view>

namespace acus::report {

inline constexpr std::string_view kStyleSheet = R"css(
:root { color-scheme: light dark; --ink: #1c1e21; --paper: #ffffff; --soft: #f4f5f7;
  --rule: #d5d8dd; --quiet: #5b626b; --link: #0b5cad; --alert: #8a4b00; --alert-paper: #fff4e0; }
@media (prefers-color-scheme: dark) { :root { --ink: #e4e6e9; --paper: #17191c; --soft: #22262b;
  --rule: #3a4048; --quiet: #a2aab4; --link: #7db8f5; --alert: #ffd08a; --alert-paper: #3a2c12; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 62rem; padding: 1.5rem 1.25rem 3rem; color: var(--ink);
  background: var(--paper); font: 16px/1.5 "DejaVu Sans", Helvetica, Arial, sans-serif; }
h1 { font-size: 1.6rem; line-height: 1.2; margin: 0 0 .2rem; }
h2 { font-size: 1.2rem; margin: 2.2rem 0 .6rem; padding-bottom: .2rem;
  border-bottom: 1px solid var(--rule); }
.subtitle { color: var(--quiet); margin: 0 0 1rem; }
a { color: var(--link); }
nav { background: var(--soft); border-radius: 6px; padding: .6rem 1rem; margin: 1rem 0; }
nav ul { list-style: none; margin: 0; padding: 0; display: flex; flex-wrap: wrap;
  gap: .2rem 1.4rem; }
.warnings { background: var(--alert-paper); border-left: 4px solid var(--alert); margin: 1rem 0;
  padding: .6rem 1rem; }
.warnings ul { margin: .3rem 0 0; padding-left: 1.2rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; margin: .4rem 0 1rem; }
caption { text-align: left; color: var(--quiet); padding-bottom: .3rem; }
th, td { padding: .28rem .8rem; border-bottom: 1px solid var(--rule); text-align: left;
  vertical-align: top; }
thead th { background: var(--soft); }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .2rem 1.2rem;
  margin: .4rem 0 1rem; }
dt { color: var(--quiet); }
dd { margin: 0; overflow-wrap: anywhere; }
figure { margin: .8rem 0 1.2rem; position: relative; }
figure svg, figure img, figure video { max-width: 100%; height: auto; display: block; }
figure svg { border-radius: 4px; }
figcaption { color: var(--quiet); font-size: .88rem; margin-top: .3rem; }
.reading { position: absolute; pointer-events: none; background: #ffffff; color: #1c1e21;
  border: 1px solid #888888; border-radius: 4px; font-size: .78rem; padding: .2rem .5rem;
  white-space: pre; box-shadow: 0 1px 4px #0004; z-index: 1; }
pre { background: var(--soft); padding: .7rem 1rem; overflow-x: auto; font-size: .8rem;
  border-radius: 6px; white-space: pre-wrap; overflow-wrap: anywhere; }
@media print { :root { --ink: #000; --paper: #fff; --soft: #fff; --quiet: #333; --link: #000;
  --alert: #000; --alert-paper: #fff; } body { max-width: none; font-size: 10pt; padding: 0; }
  nav, video { display: none; } h2 { break-after: avoid; } figure, tr { break-inside: avoid; } }
)css";

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
