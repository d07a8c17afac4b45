'use strict';

/* Draws charts, data apart from drawing: `chart` is what figures/interactive.py makes of a chart,
   `element` receives a legend and one Plotly figure a panel, laid out by the page's width. */

const PLOT_OPTIONS = {
  responsive: true,
  displaylogo: false,
  showSendToCloud: false,
  modeBarButtonsToRemove: ['select2d', 'lasso2d', 'sendChartToCloud'],
};

function make(tag, className, text = '') {
  const element = document.createElement(tag);
  element.className = className;
  element.textContent = text;
  return element;
}

function chartLegend(chart) {
  const legend = make('p', 'chart-legend');
  for (const { name, colour, symbol } of chart.legend) {
    const item = make('span', 'chart-name');
    const mark = make('span', '', symbol);
    mark.style.color = colour;
    item.append(mark, ` ${name}`);
    legend.append(item);
  }
  if (chart.scale) {
    const { label, low, high, colours } = chart.scale;
    const bar = make('span', 'chart-scale');
    bar.style.background = `linear-gradient(to right, ${colours.join(', ')})`;
    const item = make('span', 'chart-name');
    item.append(`${label} ${low} `, bar, ` ${high}`);
    legend.append(item);
  }
  return legend;
}

function drawChart(element, chart) {
  const grid = make('div', 'chart-panels');
  grid.style.setProperty('--columns', chart.columns);
  element.replaceChildren(chartLegend(chart), grid);
  for (const panel of chart.panels) {
    const cell = make('div', 'chart-panel');
    const plot = make('div', 'chart-plot');
    cell.append(make('h4', '', panel.title), make('p', 'chart-note', panel.note), plot);
    grid.append(cell);
    const layout = { ...panel.layout };
    if (panel.square) layout.height = Math.min(cell.clientWidth, 420) + 20;
    Plotly.newPlot(plot, panel.data, layout, PLOT_OPTIONS);
  }
}
