'use strict';

/* Draws charts, data apart from drawing: `chart` is what figures/interactive.py makes of a chart,
   `element` receives a legend and one Plotly figure a panel, laid out by the page's width, in the
   page's colours. A chart that is drawn again in its element keeps where the user has zoomed. */

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

function chartLayout(element, panel, width) {
  const style = getComputedStyle(element);
  const [ink, soft, line] = ['--ink', '--soft', '--line'].map((name) => style.getPropertyValue(name).trim());
  const axis = (given) => ({ ...given, gridcolor: line, linecolor: soft, zerolinecolor: soft });
  return {
    ...panel.layout,
    ...(panel.square ? { height: Math.min(width, 420) + 20 } : {}),
    font: { ...panel.layout.font, color: ink },
    xaxis: axis(panel.layout.xaxis),
    yaxis: axis(panel.layout.yaxis),
    paper_bgcolor: 'rgba(0, 0, 0, 0)',
    plot_bgcolor: 'rgba(0, 0, 0, 0)',
    modebar: { bgcolor: 'rgba(0, 0, 0, 0)', color: line, activecolor: soft },
    uirevision: 'kept',
  };
}

function chartPanels(element, chart) {
  const grid = make('div', 'chart-panels');
  grid.style.setProperty('--columns', chart.columns);
  for (const panel of chart.panels) {
    const cell = make('div', 'chart-panel');
    cell.append(make('h4', '', panel.title), make('p', 'chart-note', panel.note), make('div', 'chart-plot'));
    grid.append(cell);
  }
  element.replaceChildren(chartLegend(chart), grid);
}

function drawChart(element, chart) {
  const titles = [...element.querySelectorAll('.chart-panel h4')].map((title) => title.textContent);
  if (titles.join() === chart.panels.map((panel) => panel.title).join() && titles.length) {
    element.querySelector('.chart-legend').replaceWith(chartLegend(chart));
  } else {
    chartPanels(element, chart);
  }
  const plots = element.querySelectorAll('.chart-plot');
  chart.panels.forEach((panel, k) => {
    const layout = chartLayout(element, panel, plots[k].clientWidth);
    Plotly.react(plots[k], panel.data, layout, PLOT_OPTIONS);
  });
}
