#include "base/number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { ALL_DIGITS = 17 }; /* no double needs more */

struct number_text number_exact(double value)
{
	struct number_text number;
	for (int digits = 6; digits <= ALL_DIGITS; digits++) {
		snprintf(number.text, sizeof number.text, "%.*g", digits, value);
		if (strtod(number.text, NULL) == value)
			break;
	}
	return number;
}

/* `side`: 1 for at least, -1 for at most. */
static struct number_text on_side(double value, int digits, int side)
{
	struct number_text number;
	double shown = value;
	/* printf rounds to the nearest. A second try takes the last digit to the other side. */
	for (int tries = 0; tries < 3; tries++) {
		snprintf(number.text, sizeof number.text, "%.*g", digits, shown);
		const double read = strtod(number.text, NULL);
		if (!isfinite(value) || value == 0 || side * (read - value) >= 0)
			return number;
		shown = read + side * pow(10, floor(log10(fabs(value))) - digits + 1);
	}
	return number_exact(value);
}

struct number_text number_at_most(double value, int digits)
{
	return on_side(value, digits, -1);
}

struct number_text number_at_least(double value, int digits)
{
	return on_side(value, digits, 1);
}

struct number_window number_window(double west, double south, double east, double north)
{
	enum { DIGITS = 10 };
	struct number_window window;
	snprintf(window.text, sizeof window.text, "%s,%s,%s,%s", number_at_most(west, DIGITS).text, number_at_most(south, DIGITS).text,
		 number_at_least(east, DIGITS).text, number_at_least(north, DIGITS).text);
	return window;
}
