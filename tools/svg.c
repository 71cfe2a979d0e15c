#include "svg.h"

#include <math.h>

void svg_text(const char *text, FILE *file)
{
	for (const unsigned char *at = (const unsigned char *)text; *at != '\0'; at++)
		if (*at == '<')
			fputs("&lt;", file);
		else if (*at == '&')
			fputs("&amp;", file);
		else
			fputc(*at < ' ' ? '?' : *at, file);
}

double svg_step(double least)
{
	const double power = pow(10, floor(log10(least))), factor = least / power;
	return power * (factor <= 1 ? 1 : factor <= 2 ? 2 : factor <= 5 ? 5 : 10);
}

void svg_axis(double *low, double *high, double *step)
{
	if (!(*high > *low)) {
		*low = isfinite(*low) ? *low - 0.5 : 0;
		*high = *low + 1;
	}
	*step = svg_step((*high - *low) / 7);
	*low = floor(*low / *step + 1e-9) * *step;
	*high = ceil(*high / *step - 1e-9) * *step;
}
