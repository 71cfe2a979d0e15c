/* furrow fit-soil: what its files share. */
#ifndef FURROW_TOOLS_FIT_SOIL_H
#define FURROW_TOOLS_FIT_SOIL_H

#include <stdio.h>

#include "fit/fit.h"

struct fit_soil {
	struct fit_table plate, shear, penetration;
	bool has_plate, has_shear, has_penetration; /* one of them at least */
	struct fit_plates plates;
	struct fit_shear strength;
	struct fit_penetration faces;
	enum fit_method method; /* whose numbers the soil has */
	const char *named;      /* the soil that has the numbers that were not measured */
};

extern const char *const fit_soil_methods[]; /* by enum fit_method, ended by NULL */

/* fit_soil_told.c */
const char *fit_soil_error(double error, char text[32]);         /* two digits; returns text */
void fit_soil_print(const struct fit_soil *fit);                 /* on stdout: numbers, standard errors, residuals */
void fit_soil_block(const struct fit_soil *fit, FILE *file);     /* a scene's `soil:` */
enum status fit_soil_json(const struct fit_soil *fit) FURROW_CHECKED;
/* fit_soil_page.c: one HTML page with plots. A write that fails is told by the file's own error. */
enum status fit_soil_page(const struct fit_soil *fit, FILE *file) FURROW_CHECKED;

#endif
