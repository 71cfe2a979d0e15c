/*
 * Counts what an OBJ, an STL or a DAE file has before assimp reads it. assimp takes some hundred bytes for a face, and more for a group.
 * For some shapes its time grows with the square of their number. So a small file could take all memory, or hours.
 */
#include <ctype.h>
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

#define DEPTH_MOST 256       /* elements of a DAE in each other */
#define ELEMENTS_MOST 200000u
#define COPIES_MOST 1000000u /* nodes that instances of nodes may make */

/* Counts elements, and refuses those too deep in each other: assimp calls itself for each. */
static enum status count_elements(const char *bytes, size_t length, const char *told)
{
	size_t elements = 0;
	long depth = 0;
	for (size_t i = 0; i + 1 < length; i++) {
		if (bytes[i] != '<' || bytes[i + 1] == '?' || bytes[i + 1] == '!')
			continue;
		const char *end = memchr(bytes + i, '>', length - i);
		const bool closes = bytes[i + 1] == '/', single = end != NULL && end[-1] == '/';
		depth += closes ? -1 : single ? 0 : 1;
		if (++elements > ELEMENTS_MOST)
			return too_many(told, "elements", ELEMENTS_MOST);
		if (depth > DEPTH_MOST)
			return too_many(told, "elements in each other", DEPTH_MOST);
	}
	return STATUS_OK;
}

static const char *find(const char *at, const char *end, const char *word)
{
	const size_t size = strlen(word);
	while ((size_t)(end - at) >= size && memcmp(at, word, size) != 0)
		at++;
	return (size_t)(end - at) >= size ? at : NULL;
}

/* Returns the next library of nodes, and where it ends: at its closing tag, or with the file. NULL: there is none. */
static const char *next_library(const char *at, const char *end, const char **stop)
{
	const char *library = find(at, end, "<library_nodes"), *closes = library != NULL ? find(library, end, "</library_nodes") : NULL;
	*stop = closes != NULL ? closes : end;
	return library;
}

/* Returns true if a node of a library has this id, as id="..." between the library's tags. */
static bool is_of_library(const char *bytes, size_t length, const char *id, size_t id_length)
{
	static const char word[] = "id=\"";
	const size_t of = sizeof word - 1;
	const char *stop;
	for (const char *at = bytes; (at = next_library(at, bytes + length, &stop)) != NULL; at = stop)
		for (; (size_t)(stop - at) > of + id_length; at++)
			if (*at == 'i' && isspace((unsigned char)at[-1]) && memcmp(at, word, of) == 0 && memcmp(at + of, id, id_length) == 0 && at[of + id_length] == '"')
				return true;
	return false;
}

#define INSTANCES_MOST 1000u /* of nodes */

/* assimp looks for the node of an instance first in libraries, then in the scene. A node of the scene may hold the instance itself: assimp would copy it
 * without an end. So each instance must be of a library's node. */
static enum status check_instances(const char *bytes, size_t length, const char *told)
{
	static const char word[] = "<instance_node", url[] = "url=\"#";
	size_t instances = 0;
	if (strstr(bytes, word) != NULL && strstr(bytes, "<!") != NULL)
		return fail_with(STATUS_INPUT, "%s: it has instances of nodes, and comments, in which more may hide; export the mesh as STL", told);
	for (const char *at = bytes, *end = bytes + length; (at = memchr(at, '<', (size_t)(end - at))) != NULL; at++) {
		if ((size_t)(end - at) < sizeof word || memcmp(at, word, sizeof word - 1) != 0)
			continue;
		const char *stop = memchr(at, '>', (size_t)(end - at)), *id = strstr(at, url), *quote = id != NULL ? strchr(id + sizeof url - 1, '"') : NULL;
		if (++instances > INSTANCES_MOST)
			return too_many(told, "instances of nodes", INSTANCES_MOST);
		if (stop == NULL || quote == NULL || quote > stop || !is_of_library(bytes, length, id + sizeof url - 1, (size_t)(quote - id) - (sizeof url - 1)))
			return fail_with(STATUS_INPUT, "%s: an instance of a node is of none in a library, and may be of one that it is in; export the mesh as STL", told);
	}
	return STATUS_OK;
}

enum status scene_mesh_count_dae(const char *bytes, size_t length, const char *told)
{
	TRY(count_elements(bytes, length, told));
	TRY(check_instances(bytes, length, told));
	/* Nodes of a library could hold instances of each other, without an end. */
	const size_t instances = count_of(bytes, length, "<instance_node"), nodes = count_of(bytes, length, "<node");
	const char *stop;
	for (const char *at = bytes; instances > 0 && (at = next_library(at, bytes + length, &stop)) != NULL; at = stop)
		if (count_of(at, (size_t)(stop - at), "<instance_node") > 0)
			return fail_with(STATUS_INPUT, "%s: nodes of its library have instances of nodes, which are not followed; export the mesh as STL", told);
	if (instances * nodes > COPIES_MOST)
		return too_many(told, "instances of nodes", COPIES_MOST);
	if (count_of(bytes, length, "<triangles") + count_of(bytes, length, "<polylist") + count_of(bytes, length, "<polygons") > GROUPS_MOST)
		return too_many(told, "groups", GROUPS_MOST);
	return STATUS_OK;
}
