// The near texture on steep ground. From above it would be drawn out into streaks there.

#define WALLS_FROM 0.9 // slopes between which a pixel is drawn one way or the other, by chance
#define WALLS_ALL 1.6

// Returns the place in the near texture. squares: the place from above. height: absolute, m. A wall is seen from the side: along its level
// line, by what changes most there, and upward.
vec2 walls_squares(vec2 squares, vec2 gradient, float steep, float height)
{
	if (steep < WALLS_FROM + (WALLS_ALL - WALLS_FROM) * (dither() + 0.5))
		return squares;
	vec2 level = abs(vec2(gradient.x - 2.0 * gradient.y, 2.0 * gradient.x + gradient.y));
	return vec2(level.x > level.y ? squares.x : squares.y, 0.25 * height);
}
