/*
 * Counts what an OBJ or an STL file has before assimp reads it. assimp takes some hundred bytes for a face, and more for a group.
 * For some shapes its time grows with the square of their number. So a small file could take all memory, or hours.
 */
#include <string.h>

#include "scene/scene_mesh_import.h"

#define GROUPS_MOST 20000u /* lines o, g, usemtl and mtllib of an OBJ; solids of an STL */
#define CORNERS_MOST 1000u /* of one face */

struct counts {
	size_t triangles, others, groups; /* others: points and lines */
};

static enum status too_many(const char *told, const char *what, unsigned most)
{
	return fail_with(STATUS_INPUT, "%s: it has more than %u %s; give a simpler mesh", told, most, what);
}

static enum status check(const char *told, const struct counts *counts)
{
	if (counts->triangles > SCENE_MESH_TRIANGLES)
		return too_many(told, "triangles", SCENE_MESH_TRIANGLES);
	if (counts->others > SCENE_MESH_TRIANGLES)
		return too_many(told, "points and lines", SCENE_MESH_TRIANGLES);
	return counts->groups > GROUPS_MOST ? too_many(told, "groups", GROUPS_MOST) : STATUS_OK;
}

/* Counts the words of a line, and finds its end. A line that ends in a backslash goes on. */
static size_t words_of(const char *at, const char *end, const char **next)
{
	size_t words = 0;
	bool word = false;
	for (; at < end && *at != '\n'; at++) {
		const bool joined = *at == '\\' && end - at > 1 && (at[1] == '\n' || at[1] == '\r');
		if (joined)
			at += end - at > 2 && at[1] == '\r' && at[2] == '\n' ? 2 : 1;
		const bool space = joined || *at == ' ' || *at == '\t' || *at == '\r' || *at == '\f';
		words += !space && !word;
		word = !space;
	}
	*next = at < end ? at + 1 : end;
	return words;
}

enum status scene_mesh_count_obj(const char *bytes, size_t length, const char *told)
{
	struct counts counts = {0, 0, 0};
	const char *end = bytes + length;
	for (const char *at = bytes, *next; at < end; at = next) {
		while (at < end && (*at == ' ' || *at == '\t'))
			at++;
		const char first = at < end ? *at : '\0';
		const size_t words = words_of(at, end, &next);
		if (first == 'f' && words > CORNERS_MOST + 1)
			return too_many(told, "corners in one face", CORNERS_MOST);
		counts.triangles += first == 'f' && words > 3 ? words - 3 : 0;
		counts.others += first == 'l' || first == 'p' || (first == 'f' && words <= 3) ? words : 0;
		counts.groups += first == 'o' || first == 'g' || first == 'u' || first == 'm';
		TRY(check(told, &counts));
	}
	return STATUS_OK;
}

static size_t count_of(const char *bytes, size_t length, const char *word)
{
	const size_t size = strlen(word);
	size_t count = 0;
	for (size_t i = 0; i + size <= length; i++)
		count += bytes[i] == word[0] && memcmp(bytes + i, word, size) == 0;
	return count;
}

enum status scene_mesh_count_stl(const char *bytes, size_t length, const char *told)
{
	uint32_t triangles = 0;
	if (length >= 84)
		memcpy(&triangles, bytes + 80, sizeof triangles);
	if (length >= 84 && 84 + 50 * (uint64_t)triangles == length) /* binary */
		return check(told, &(struct counts){triangles, 0, 0});
	struct counts counts = {count_of(bytes, length, "facet normal"), 0, count_of(bytes, length, "solid")};
	counts.others = count_of(bytes, length, "vertex") / 3;
	return check(told, &counts);
}

#define DAE_DEPTH_MOST 100     /* elements in each other */
#define DAE_ELEMENTS_MOST 200000u

/* assimp follows elements, and nodes that name others, without a limit. A node may name one that it is in. */
enum status scene_mesh_count_dae(const char *bytes, size_t length, const char *told)
{
	static const char again[] = "<instance_node";
	const char *end = bytes + length;
	size_t elements = 0;
	int depth = 0;
	if (memchr(bytes, '\0', length) != NULL)
		return fail_with(STATUS_INPUT, "%s: it has a NUL byte; give a text that is whole", told);
	if (strstr(bytes, again) != NULL)
		return fail_with(STATUS_INPUT, "%s: its nodes name others (instance_node); export it as STL or OBJ", told);
	for (const char *at = bytes; (at = memchr(at, '<', (size_t)(end - at))) != NULL;) {
		const char *stop = strncmp(at, "<!--", 4) == 0 ? strstr(at, "-->") : memchr(at, '>', (size_t)(end - at));
		if (stop == NULL)
			return fail_with(STATUS_INPUT, "%s: its XML is not whole; export it again", told);
		if (at[1] == '/')
			depth--;
		else if (at[1] != '!' && at[1] != '?') {
			elements++;
			depth += stop[-1] != '/';
		}
		if (depth > DAE_DEPTH_MOST || elements > DAE_ELEMENTS_MOST)
			return fail_with(STATUS_INPUT, "%s: it has more than %u elements, or more than %d in each other; give a simpler mesh", told, DAE_ELEMENTS_MOST, DAE_DEPTH_MOST);
		at = stop;
	}
	return STATUS_OK;
}
