/* What the plots of the command share. */
#ifndef FURROW_TOOLS_SVG_H
#define FURROW_TOOLS_SVG_H

#include <stdio.h>

/* Writes text as SVG and HTML have it, also between quotes. Control characters become question marks, bytes that are no UTF-8 too. */
void svg_text(const char *text, FILE *file);
/* Returns the distance between an axis's lines: the smallest of 1, 2 or 5 times a power of ten that is at least `least`, above 0. */
double svg_step(double least);
/* Rounds an axis outward to steps of 1, 2 or 5 times a power of ten, about seven of them. An empty range becomes one of length 1. */
void svg_axis(double *low, double *high, double *step);

#endif
