/*
 * Looks at the text of an SRS before GDAL or PROJ do. A text may come from a store, a scene or a raster. GDAL opens what it takes
 * for the name of a file or an address on a network, and PROJ opens grids that a text names.
 *
 * A text may name a grid by its bare name: PROJ then looks in its own folders.
 */
#include "dem_gdal.h"

#include <ctype.h>
#include <strings.h>
#include <sys/stat.h>

#define LONGEST (64 << 10) /* bytes of a text */

static bool begins(const char *text, const char *with)
{
	return strncasecmp(text, with, strlen(with)) == 0;
}

/* Returns true for NAME[ and NAME(: the beginning of WKT. */
static bool is_wkt(const char *text)
{
	const char *at = text;
	while (isalpha((unsigned char)*at) || *at == '_')
		at++;
	const bool named = at > text;
	at += strspn(at, " \t\r\n");
	return named && (*at == '[' || *at == '(');
}

/* A name of OGC that is written as an address: GDAL reads it as a code, and opens nothing. */
static bool is_ogc_name(const char *text)
{
	static const char *const names[] = {"http://www.opengis.net/def/crs", "https://www.opengis.net/def/crs", "http://opengis.net/def/crs",
					    "https://opengis.net/def/crs", "http://www.opengis.net/gml/srs"};
	for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
		if (begins(text, names[i]))
			return true;
	return false;
}

static bool has(const char *text, const char *word)
{
	const size_t length = strlen(word);
	for (; *text != '\0'; text++)
		if (strncasecmp(text, word, length) == 0)
			return true;
	return false;
}

/* Returns true if a text has something that PROJ takes for the name of a file. */
static bool names_files(const char *text)
{
	static const char *const words[] = {"grids", "parameterfile", "file=", "init=", "catalog", "model=", "geoid_model", "\"parameters\""};
	for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
		if (has(text, words[i]))
			return true;
	return false;
}

/* Returns true if a text has a slash as paths have it: not " / ", and not within words, as in "m/s". */
static bool has_path(const char *text)
{
	for (const char *at = text; *at != '\0'; at++) {
		if (*at != '/')
			continue;
		const char before = at > text ? at[-1] : '\0', after = at[1];
		const bool apart = before == ' ' && after == ' ', within = isalnum((unsigned char)before) && isalnum((unsigned char)after);
		if (!apart && !within)
			return true;
	}
	return false;
}

/* PROJJSON may name its schema. Goes on behind it. */
static const char *past_schema(const char *text)
{
	static const char schema[] = "\"$schema\"";
	const char *at = strstr(text, schema);
	for (int quotes = 0; at != NULL && *at != '\0' && quotes < 4; at++)
		quotes += *at == '"';
	return at != NULL ? at : text;
}

const char *dem_srs_text_problem(const char *text)
{
	struct stat found;
	text += strspn(text, " \t\r\n");
	const bool json = text[0] == '{', proj = text[0] == '+' || has(text, "proj=") || has(text, "init="), wkt = is_wkt(text);
	if (strlen(text) > LONGEST)
		return "it has more than 64 KiB";
	if (!json && !proj && !wkt && !is_ogc_name(text) && strstr(text, "://") != NULL)
		return "it is an address, and nothing is fetched";
	if (!json && !proj && !wkt && (strchr("/.~", text[0]) != NULL || begins(text, "DICT:") || stat(text, &found) == 0))
		return "it is the name of a file, and none is opened";
	if ((json || proj || wkt) && names_files(text) && has_path(json ? past_schema(text) : text))
		return "it names a file by a path, and none is opened";
	return NULL;
}
