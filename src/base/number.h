/*
 * Numbers in messages that a user types again. Rounding must not turn a number that is allowed into one that is refused. So each
 * function says to which side it rounds. All take the locale as printf does. Any thread.
 */
#ifndef FURROW_BASE_NUMBER_H
#define FURROW_BASE_NUMBER_H

struct number_text {
	char text[32];
};
struct number_window {
	char text[140];
};

/* Returns the fewest digits that are read back as this same number. */
struct number_text number_exact(double value);
/* Returns `digits` significant digits, 1 to 17, that are read back as at most `value`. The last digit is the largest for which that holds. */
struct number_text number_at_most(double value, int digits);
/* The same, as at least `value`. */
struct number_text number_at_least(double value, int digits);
/* Returns "WEST,SOUTH,EAST,NORTH" with 10 digits, rounded outwards: what lies on the rim of the window lies within what is read back. */
struct number_window number_window(double west, double south, double east, double north);

#endif
