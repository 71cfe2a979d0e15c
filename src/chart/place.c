/* Reads the name and the code of a reference system out of its WKT, which a store has from its source and is not trusted. */
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "chart/internal.h"

/* Copies the text between quotes at *at, and moves *at behind it. Two quotes are one. */
static void take_quoted(const char **at, char *text, size_t room)
{
	size_t used = 0;
	const char *p = *at + 1;
	for (; *p != '\0' && (*p != '"' || p[1] == '"'); p++) {
		p += *p == '"';
		if (used + 1 < room)
			text[used++] = *p;
	}
	text[used] = '\0';
	*at = *p == '"' ? p + 1 : p;
}

/* At "ID[" or "AUTHORITY[" of the whole system: reads authority and code. */
static bool take_code(const char *at, char *code, size_t room)
{
	char authority[32], number[32];
	at = strchr(at, '[') + 1;
	if (*at != '"')
		return false;
	take_quoted(&at, authority, sizeof authority);
	if (*at++ != ',')
		return false;
	if (*at == '"')
		take_quoted(&at, number, sizeof number);
	else
		snprintf(number, sizeof number, "%.*s", (int)strcspn(at, ",]"), at);
	snprintf(code, room, "%s:%s", authority, number);
	return true;
}

static bool is_name(const char *text)
{
	return text[0] != '\0' && strcasecmp(text, "unnamed") != 0 && strcasecmp(text, "unknown") != 0;
}

/* Reads the name in the first of `keyword`, as in DATUM["...". Returns false if there is none, or it says nothing. */
static bool find_name(const char *wkt, const char *keyword, char *text, size_t room)
{
	text[0] = '\0';
	for (const char *at = wkt; *at != '\0' && text[0] == '\0';)
		if (*at == '"') {
			char skipped[4];
			take_quoted(&at, skipped, sizeof skipped);
		} else if (strncmp(at, keyword, strlen(keyword)) == 0 && at[strlen(keyword)] == '[' && at[strlen(keyword) + 1] == '"') {
			at += strlen(keyword) + 1;
			take_quoted(&at, text, room);
		} else {
			at++;
		}
	return is_name(text);
}

/* Says of a system without a name how it is projected, and on what datum. */
static void describe_unnamed(const char *wkt, char *text, size_t room)
{
	static const char *const bases[] = {"GEOGCRS", "GEODCRS", "GEOGCS", "DATUM", "ENSEMBLE"}; /* BASEGEOGCRS too */
	char how[96], on[96] = "";
	for (size_t i = 0; i < sizeof bases / sizeof bases[0] && !is_name(on); i++)
		find_name(wkt, bases[i], on, sizeof on);
	const bool projected = find_name(wkt, "CONVERSION", how, sizeof how);
	if (is_name(on))
		snprintf(text, room, "unnamed, %s%son %s", projected ? how : "", projected ? " " : "", on);
}

void chart_system_name(const char *wkt, char *text, size_t room)
{
	char name[96] = "", code[72] = "";
	int depth = 0;
	for (const char *at = wkt; *at != '\0';) {
		if (*at == '"') {
			char quoted[96];
			take_quoted(&at, quoted, sizeof quoted);
			if (depth == 1 && name[0] == '\0')
				snprintf(name, sizeof name, "%s", quoted);
			continue;
		}
		if (depth == 1 && (strncmp(at, "ID[", 3) == 0 || strncmp(at, "AUTHORITY[", 10) == 0) &&
		    !take_code(at, code, sizeof code))
			code[0] = '\0';
		depth += *at == '[' ? 1 : *at == ']' ? -1 : 0;
		at++;
	}
	if (name[0] == '\0')
		text[0] = '\0';
	else if (code[0] == '\0')
		snprintf(text, room, "%s", name);
	else
		snprintf(text, room, "%s (%s)", name, code);
	if (!is_name(name) && code[0] == '\0')
		describe_unnamed(wkt, text, room);
}
