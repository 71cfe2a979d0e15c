"""The pictures of paging.py as SVG: grouped bars, and lines over time."""
import html

COLOURS = ("#4477aa", "#66ccee", "#228833", "#ccbb44", "#ee6677", "#aa3377", "#bbbbbb", "#000000")
WIDTH, HEIGHT, LEFT, TOP, BOTTOM = 900, 420, 60, 40, 70


def scale(most):
    """The next of 1, 2, 5, 10, ... that is no less."""
    unit = 1e-6
    while unit * 10 < most:
        unit *= 10
    return next(unit * n for n in (1, 2, 5, 10) if unit * n >= most)


def page(title, unit, most, inside, legend):
    text = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" '
            'font-size="12"><rect width="100%" height="100%" fill="white"/>',
            f'<text x="{LEFT}" y="20" font-size="15">{html.escape(title)}</text>']
    for i in range(5):
        y = TOP + (HEIGHT - TOP - BOTTOM) * (4 - i) / 4
        text.append(f'<line x1="{LEFT}" x2="{WIDTH - 10}" y1="{y}" y2="{y}" stroke="#ddd"/>'
                    f'<text x="{LEFT - 5}" y="{y + 4}" text-anchor="end">{most * i / 4:g}</text>')
    text.append(f'<text x="5" y="{TOP - 8}">{html.escape(unit)}</text>')
    for i, name in enumerate(legend):
        text.append(f'<rect x="{LEFT + 200 * (i % 4)}" y="{HEIGHT - 34 + 16 * (i // 4)}" width="10" height="10" '
                    f'fill="{COLOURS[i % len(COLOURS)]}"/><text x="{LEFT + 14 + 200 * (i % 4)}" '
                    f'y="{HEIGHT - 25 + 16 * (i // 4)}">{html.escape(name)}</text>')
    return "\n".join(text + inside + ["</svg>\n"])


def bars(title, unit, groups, legend):
    """groups: [(name, [value or None for each of legend])]."""
    most = scale(max((value for _, values in groups for value in values if value is not None), default=1))
    inside, room = [], (WIDTH - LEFT - 10) / max(1, len(groups))
    for i, (name, values) in enumerate(groups):
        x, wide = LEFT + room * i, room * 0.8 / len(legend)
        for j, value in enumerate(values):
            if value is not None:
                high = (HEIGHT - TOP - BOTTOM) * value / most
                inside.append(f'<rect x="{x + room * 0.1 + wide * j:.1f}" y="{HEIGHT - BOTTOM - high:.1f}" '
                              f'width="{wide * 0.9:.1f}" height="{high:.1f}" fill="{COLOURS[j % len(COLOURS)]}">'
                              f'<title>{value:g} {html.escape(unit)}</title></rect>')
        inside.append(f'<text x="{x + room / 2}" y="{HEIGHT - BOTTOM + 16}" text-anchor="middle">'
                      f'{html.escape(name)}</text>')
    return page(title, unit, most, inside, legend)


def lines(title, unit, series):
    """series: [(name, [(seconds, value)])]."""
    points = [point for _, found in series for point in found]
    most = scale(max((value for _, value in points), default=1))
    longest = max((at for at, _ in points), default=1) or 1
    inside = []
    for i, (_, found) in enumerate(series):
        drawn = " ".join(f"{LEFT + (WIDTH - LEFT - 10) * at / longest:.1f},"
                         f"{HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * value / most:.1f}" for at, value in found)
        inside.append(f'<polyline points="{drawn}" fill="none" stroke="{COLOURS[i % len(COLOURS)]}"/>')
    inside.append(f'<text x="{WIDTH - 10}" y="{HEIGHT - BOTTOM + 16}" text-anchor="end">{longest:.0f} s</text>')
    return page(title, unit, most, inside, [name for name, _ in series])
