/*
 * A covering array: six choices out of up to ten things, each in or out. Any two things are met in all four ways: both, either, none.
 * What goes wrong by one thing, or by two together, goes wrong in one of the six; all choices would be 2 to the number of things.
 */
#ifndef FURROW_TESTS_PAIRS_H
#define FURROW_TESTS_PAIRS_H

#include <stdint.h>

enum { PAIRS_CHOICES = 6, PAIRS_THINGS = 10 };

/* Bit f of a choice: thing f is in. Each thing is in another three of the first five choices; none is in the last. */
static const uint16_t pairs_choices[PAIRS_CHOICES] = {0x03f, 0x1c7, 0x2d9, 0x36a, 0x3b4, 0};

/* The ways in which two things are met, as bits: 15 for all four. */
static inline unsigned pairs_met(int one, int other)
{
	unsigned met = 0;
	for (int i = 0; i < PAIRS_CHOICES; i++)
		met |= 1u << ((pairs_choices[i] >> one & 1) + 2 * (pairs_choices[i] >> other & 1));
	return met;
}

#endif
