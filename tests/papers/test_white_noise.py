"""White noise printed by S: correlated noise shorter than a frame is part of it."""

from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.papers.power_laws import white_level, white_roots


def test_white_noise_of_a_component_below_a_frame_is_counted() -> None:
    """T40 y1 with 2 cameras: T_c 2 ms; h_0 alone is 58 times below that with 3 cameras."""
    two, three = (white_level(published_row("T40", n)["y1"]) for n in (2, 3))
    assert 0.2 < two / three < 5
    x = published_row("T40", 10)["x1"]
    assert white_level(x) == x.coefficients()["h_0"]
    assert 10 not in white_roots()["Vantage"][0]
