"""Charts as data, and what is made of them for print and screen."""

import json

import numpy as np
import pytest
from PIL import Image

from coevo_manager.analysis.figures.charts import Chart, Heat, Line, Panel, Points, Spans
from coevo_manager.analysis.figures.draw import draw, edges, save
from coevo_manager.analysis.figures.interactive import chart_data

GENERATIONS = np.array([0, 10_000, 20_000, 50_000])


def chart(*marks, **fields):
    panels = [Panel(f'Panel {k}', 'Generation', 'Fitness', marks) for k in range(3)]
    return Chart('kind', 'Title', 'Caption', [panels], 'open arena, signed', **fields)


def curve():
    low, high = [0.1, 0.2, np.nan, 0.4], [0.3, 0.4, np.nan, 0.6]
    return Line(GENERATIONS, [0.2, 0.3, np.nan, 0.5], 'Prey', '#3b93cf', low=low, high=high)


def test_kind_and_arena_name_the_files():
    assert chart(curve()).name == 'kind_open_arena_signed'
    assert Chart('kind', 'Title', 'Caption', []).name == 'kind'


def test_cells_of_maps_lie_around_their_generations():
    assert edges(GENERATIONS) == pytest.approx([-5000, 5000, 15_000, 35_000, 65_000])
    assert edges([7]) == pytest.approx([6.5, 7.5])


def test_maps_share_one_scale_on_true_generations():
    made = chart(Heat(GENERATIONS, GENERATIONS, np.eye(4), 'Predator fitness'))
    with_bar = draw(made)
    assert len(with_bar.axes) == 3 + 1
    assert with_bar.axes[0].get_xlim() == pytest.approx((-5000, 65_000))
    data = chart_data(made)
    assert data['scale']['label'] == 'Predator fitness'
    assert data['panels'][0]['data'][0]['x'] == GENERATIONS.tolist()
    assert not data['panels'][0]['data'][0]['showscale']


def test_data_for_the_screen_is_json_without_nan():
    made = chart(
        curve(),
        Spans([(0, 500), (1000, 1500)], 'Predators evolve', '#b3341f'),
        Points([0.1, 0.2], [0.3, 0.4], 'Prey', '#3b93cf', 'circle', ['0', '10k'], path=True),
    )
    data = json.loads(json.dumps(chart_data(made), allow_nan=False))
    panel = data['panels'][0]
    band, line, points = panel['data']
    assert line['y'] == [0.2, 0.3, None, 0.5]
    assert band['x'] == [0, 10_000, 50_000, 50_000, 10_000, 0]
    assert points['marker']['size'] == [5, 12]
    assert [shape['x1'] for shape in panel['layout']['shapes']] == [500, 1500]
    assert [item['name'] for item in data['legend']] == ['Prey', 'Predators evolve']


def test_what_bands_mean_stands_in_the_picture(tmp_path):
    made = chart(curve(), note='Bands: what they are.')
    figure = draw(made)
    assert figure.legends[0].get_title().get_text() == 'Bands: what they are.'
    png, svg = save(figure, tmp_path / made.name)
    with Image.open(png) as image:
        assert image.getpixel((0, 0)) == image.getpixel((1, 1))
        assert image.convert('RGB').getpixel((0, 0)) == (255, 255, 255)
    assert svg.read_bytes() == save(draw(made), tmp_path / 'again')[1].read_bytes()
