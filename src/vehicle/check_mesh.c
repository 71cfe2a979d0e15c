/*
 * Meshes of a model: OBJ, MSH, and those that its text has. MuJoCo believes the numbers of their faces: one beyond the vertices makes
 * it read what is not there. An OBJ's face with very many corners takes it hours.
 */
#include "vehicle/check.h"

#include <stdlib.h>
#include <string.h>

#define CORNERS_MOST 1000
#define FACES_MOST 1000000

struct counts {
	long long kinds[3]; /* of vertices, texture coordinates, normals */
	size_t faces;
};

static bool is_space(char c)
{
	return c == ' ' || c == '\t' || c == '\r';
}

/* Counts a line that begins with a vertex, a texture coordinate or a normal. */
static void count(const char *line, struct counts *counts)
{
	if (line[0] == 'v' && (is_space(line[1]) || line[1] == 't' || line[1] == 'n'))
		counts->kinds[line[1] == 't' ? 1 : line[1] == 'n' ? 2 : 0]++;
}

/* Checks one corner: "v", "v/vt", "v//vn" or "v/vt/vn". `here`: what came before the line; negative numbers count back from it. */
static bool is_corner(const char *at, const char *end, const struct counts *here, const struct counts *all)
{
	for (int kind = 0; kind < 3; kind++) {
		char *rest;
		if (at < end && *at != '/') {
			const long long number = strtoll(at, &rest, 10);
			if (rest == at || rest > end || number == 0 || number > all->kinds[kind] || -number > here->kinds[kind])
				return false;
			at = rest;
		}
		if (at == end)
			return true;
		if (*at++ != '/')
			return false;
	}
	return at == end;
}

/* Returns why a face cannot be read; NULL: it can. */
static const char *problem_of(const char *at, const struct counts *here, const struct counts *all)
{
	size_t corners = 0;
	for (at += 1; *at != '\0';) {
		while (is_space(*at))
			at++;
		const char *end = at;
		while (*end != '\0' && !is_space(*end))
			end++;
		if (end > at && ++corners > CORNERS_MOST)
			return "it has a face of more than 1000 corners";
		if (end > at && !is_corner(at, end, here, all))
			return "it has a face with a corner that is not there";
		at = end;
	}
	return NULL;
}

/* Ends each line by a NUL, so that it is a text; *next is the one behind it. */
static char *line_at(char *at, char *end, char **next)
{
	char *stop = memchr(at, '\n', (size_t)(end - at));
	*next = stop != NULL ? stop + 1 : end;
	if (stop != NULL)
		*stop = '\0';
	while (is_space(*at))
		at++;
	return at;
}

const char *vehicle_check_obj(char *text, size_t length)
{
	struct counts all = {.faces = 0}, here = {.faces = 0};
	char *end = text + length, *next;
	const char *problem = memchr(text, '\0', length) != NULL ? "it has a NUL byte" : NULL;
	for (char *at = text; at < end && problem == NULL; at = next) {
		const char *line = line_at(at, end, &next);
		count(line, &all);
		if (length > 0 && strlen(line) > 0 && line[strlen(line) - 1] == '\\')
			problem = "a line of it goes on in the next one";
	}
	for (char *at = text; at < end && problem == NULL; at += strlen(at) + 1) {
		const char *line = at + strspn(at, " \t\r");
		count(line, &here);
		if (line[0] == 'f' && is_space(line[1]))
			problem = ++here.faces > FACES_MOST ? "it has more than 1000000 faces" : problem_of(line, &here, &all);
	}
	return problem;
}

/* --- MSH: four counts, vertices of 12 bytes, normals of 12, texture coordinates of 8, faces of 12 --- */

static long long word_at(const char *bytes, size_t number)
{
	int32_t word;
	memcpy(&word, bytes + 4 * number, sizeof word);
	return word;
}

const char *vehicle_check_msh(const char *bytes, size_t length)
{
	if (length < 16)
		return NULL; /* MuJoCo refuses it, and one of another length */
	const long long vertices = word_at(bytes, 0), normals = word_at(bytes, 1), places = word_at(bytes, 2), faces = word_at(bytes, 3);
	if (vertices < 0 || normals < 0 || places < 0 || faces < 0 || 16 + 12 * (vertices + normals + faces) + 8 * places != (long long)length)
		return NULL;
	const size_t first = (size_t)(4 + 3 * (vertices + normals) + 2 * places);
	for (size_t i = 0; i < 3 * (size_t)faces; i++)
		if (word_at(bytes, first + i) < 0 || word_at(bytes, first + i) >= vertices)
			return "it has a face with a corner that is not there";
	return NULL;
}

/* --- in the model's text --- */

bool vehicle_check_faces(const char *faces, size_t length, size_t vertices)
{
	const char *end = faces + length;
	while (faces < end) {
		char *rest;
		const double number = strtod(faces, &rest); /* the text goes on behind the value's quote, so it ends there at the latest */
		if (rest == faces)
			return true; /* MuJoCo tells */
		if (!(number >= 0 && number < (double)vertices))
			return false;
		faces = rest;
	}
	return true;
}
