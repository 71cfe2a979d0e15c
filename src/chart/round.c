/* Numbers that people read: round lengths and steps, and how they are written. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "chart/internal.h"

#define NARROW "\xe2\x80\xaf" /* U+202F, a narrow space that no line is broken at */
#define MINUS "\xe2\x88\x92"  /* U+2212 */

double chart_round_length(double most)
{
	double ten = pow(10, floor(log10(most) + 1e-9));
	double times = most / ten * (1 + 1e-9);
	return times >= 5 ? 5 * ten : times >= 2 ? 2 * ten : ten;
}

double chart_round_step(double least)
{
	double ten = pow(10, floor(log10(least) + 1e-9));
	double times = least / ten * (1 - 1e-9);
	return times <= 1 ? ten : times <= 2 ? 2 * ten : times <= 5 ? 5 * ten : 10 * ten;
}

double chart_round_range(double size)
{
	static const double ends[] = {1, 1.5, 2, 3, 4, 5, 6, 8, 10};
	double ten = pow(10, floor(log10(size) + 1e-9));
	size_t i = 0;
	while (ends[i] * ten < size * (1 - 1e-6))
		i++;
	return ends[i] * ten;
}

void chart_number(double value, double step, char *text, size_t room)
{
	char plain[64];
	int digits = step >= 1 || !(step > 0) ? 0 : (int)ceil(-log10(step) - 1e-9);
	snprintf(plain, sizeof plain, "%.*f", digits < 12 ? digits : 12, fabs(value));
	bool zero = strspn(plain, "0.") == strlen(plain);
	size_t whole = strcspn(plain, "."), used = 0;
	text[0] = '\0';
	if (value < 0 && !zero)
		used += (size_t)snprintf(text, room, MINUS);
	for (size_t i = 0; plain[i] != '\0' && used + 5 < room; i++) {
		if (whole >= 5 && i > 0 && i < whole && (whole - i) % 3 == 0)
			used += (size_t)snprintf(text + used, room - used, NARROW);
		text[used++] = plain[i];
		text[used] = '\0';
	}
}

void chart_length(double metres, char *text, size_t room)
{
	double unit = metres >= 1000 ? 1000 : metres >= 1 ? 1 : metres >= 0.01 ? 0.01 : 0.001;
	const char *name = metres >= 1000 ? "km" : metres >= 1 ? "m" : metres >= 0.01 ? "cm" : "mm";
	const double times = metres / unit;
	char number[48];
	if (times < 9999)
		snprintf(number, sizeof number, "%.4g", times);
	else
		chart_number(times, 1, number, sizeof number);
	snprintf(text, room, "%s %s", number, name);
}
