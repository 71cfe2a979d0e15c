/* Tyres of a host's model, told in one line: "wheel_* stiffness 50000 load 981; spare stiffness 40000 load 500 width 0.2". */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vehicle/internal.h"

#define BLANKS " \t\n"
#define GRAMMAR "give each as PATTERN stiffness N/m load N, and perhaps pressure Pa, damping N s/m, width m, with ; between them"

struct words {
	const char *where; /* for messages */
	char *next;        /* in a copy, of which words are cut */
};

/* Returns the next word of a tyre; NULL: there is none. */
static char *next_word(struct words *words)
{
	char *word = words->next + strspn(words->next, BLANKS);
	if (*word == '\0')
		return NULL;
	words->next = word + strcspn(word, BLANKS);
	if (*words->next != '\0')
		*words->next++ = '\0';
	return word;
}

static enum status read_tyre(struct words *words, struct scene_tyre *tyre)
{
	const struct {
		const char *name;
		double *to, least, most;
	} keys[] = {{"stiffness", &tyre->told.stiffness, 0, 1e12}, {"load", &tyre->told.load, 0, 1e12}, {"pressure", &tyre->told.pressure, 0, 1e9},
		    {"damping", &tyre->told.damping, 0, 1e12}, {"width", &tyre->width, 0.001, 1000}};
	tyre->width = tyre->told.stiffness = tyre->told.load = tyre->told.pressure = tyre->told.damping = (double)NAN;
	tyre->geom = next_word(words);
	for (char *key; tyre->geom != NULL && (key = next_word(words)) != NULL;) {
		const char *value = next_word(words);
		size_t k = 0;
		while (k < sizeof keys / sizeof *keys && strcmp(keys[k].name, key) != 0)
			k++;
		char *end = NULL;
		const double number = value != NULL ? strtod(value, &end) : (double)NAN;
		if (k == sizeof keys / sizeof *keys || value == NULL || *end != '\0')
			return fail_with(STATUS_INPUT, "%s: tyres: %.64s %.64s is not understood; " GRAMMAR, words->where, key, value != NULL ? value : "");
		if (!(number >= keys[k].least && number <= keys[k].most && (number > 0 || k > 1)))
			return fail_with(STATUS_INPUT, "%s: tyres: %s %.64s is out of range; give one above %g and at most %g", words->where, key, value, keys[k].least, keys[k].most);
		*keys[k].to = number;
	}
	if (tyre->geom == NULL || isnan(tyre->told.stiffness) || isnan(tyre->told.load))
		return fail_with(STATUS_INPUT, "%s: tyres: %.64s has no stiffness or no load; " GRAMMAR, words->where, tyre->geom != NULL ? tyre->geom : "one");
	return STATUS_OK;
}

static enum status set_tyre(struct vehicle *vehicle, const struct words *words, const struct scene_tyre *tyre, double gravity)
{
	const struct scene_texts pattern = {.list = (char **)&tyre->geom, .count = 1};
	bool any = false;
	for (size_t g = 0; g < vehicle->geom_count; g++) {
		struct soil_geom *geom = &vehicle->geoms[g];
		struct soil_tyre_told told = tyre->told;
		char name[256];
		vehicle_geom_name(vehicle, geom->geom, name, sizeof name);
		if (geom->shape.kind != SOIL_WHEEL || !vehicle_matches(&pattern, name, false))
			continue;
		any = true;
		if (geom->shape.tyre.stiffness > 0)
			continue; /* the first that names a wheel counts */
		geom->shape.width = isnan(tyre->width) ? geom->shape.width : tyre->width;
		told.damping = isnan(told.damping) ? scene_tyre_damping(&told, gravity) : told.damping;
		TRY(soil_tyre_set(geom->name, &told, &geom->shape, NULL));
	}
	return any ? STATUS_OK : fail_with(STATUS_INPUT, "%s: tyres: %.64s names no wheel that presses the ground; name geoms that are cylinders on a hinge along their axis", words->where, tyre->geom);
}

enum status vehicle_lent_tyres(struct vehicle *vehicle, const char *where, char *text, double gravity)
{
	for (char *next; text != NULL; text = next) {
		struct words words = {.where = where, .next = text};
		struct scene_tyre tyre = {.geom = NULL};
		next = strchr(text, ';');
		if (next != NULL)
			*next++ = '\0';
		if (next == NULL && text[strspn(text, BLANKS)] == '\0')
			return STATUS_OK; /* after the last ; */
		TRY(read_tyre(&words, &tyre));
		TRY(set_tyre(vehicle, &words, &tyre, gravity));
	}
	return STATUS_OK;
}
