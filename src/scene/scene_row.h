/*
 * The one table of a scene's keys. Each key is one row: its place in struct raw_scene, its type, range, unit, default, text, and the
 * version that brought it. So each key is described once: the reader (scene_read), the reference page, the schema for editors and the
 * completions of shells work by these rows.
 *
 * The rows are data in scene_schema*.c, an array a mapping. Pure.
 */
#ifndef FURROW_SCENE_ROW_H
#define FURROW_SCENE_ROW_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/base.h"

enum scene_row_type { ROW_NUMBER, ROW_WHOLE, ROW_SWITCH, ROW_WORD, ROW_TEXT, ROW_MAPPING };
enum scene_row_form {
	ROW_HERE,    /* the value itself is in the struct; a text is its pointer, NULL: not given */
	ROW_POINTER, /* a pointer to the value; NULL: not given */
	ROW_FIXED,   /* an array of `least` values in the struct */
	ROW_LIST,    /* a pointer to an array, and a uint32_t that counts it; NULL and 0: not given */
};

struct scene_word {
	const char *word; /* NULL ends a list of words */
	int value;
};

struct scene_row {
	const char *key;                 /* in its mapping; NULL and no `include`: the end of the rows */
	const struct scene_row *include; /* the rows of another array stand here, and nothing else is set */
	enum scene_row_type type;        /* of the value; in a list, of its entries */
	enum scene_row_form form;
	uint32_t at, count_at, size;     /* offsets of the value and of its count; bytes of one value */
	uint32_t least, most;            /* entries of a list */
	uint32_t each;                   /* numbers in each entry of a list of lists; 0: entries are single values */
	uint32_t longest;                /* bytes of a text */
	const struct scene_word *words;
	const struct scene_row *rows;    /* of a mapping */
	bool needed;                     /* its mapping must have it */
	bool command;                    /* a host may leave it out, the furrow command may not */
	double low, high;                /* range of a number, or of each number of a list */
	bool above;                      /* `low` itself is not allowed */
	const char *why;                 /* the reason in the message of a number out of range; NULL: "is out of range" */
	const char *unit;                /* NULL: a number without a unit, or a share of 1 */
	bool has_default;
	double absent;                   /* the default of a number, if `has_default` */
	const char *otherwise;           /* the default in words; NULL: none can be told */
	const char *needs;               /* when the key is needed, as "needed with points"; NULL: by `needed` and `command` alone */
	const char *named;               /* of a list of mappings: the key that a mapping's keys are values of, as in {VALUE: ...}; NULL: it is a list */
	const char *alone;               /* the key that a single value in place of a mapping means; NULL: none does */
	const char *since;               /* the version that brought the key */
	const char *text;                /* what the key does, in Markdown; NULL: its name says it */
};

/* --- macros that write rows; each checks that the member has the type of the row --- */

#define ENDLESS UINT32_MAX /* the most entries of a list that may be as long as it likes */

#define ROW_AT(in, member, kind) (uint32_t)(offsetof(in, member) + 0 * sizeof(1 ? (__typeof__(kind) *)0 : &((in *)0)->member))
#define ROW_ONE(name, of, where, in, member, value) \
	.key = name, .type = of, .form = where, .size = sizeof(value), .at = ROW_AT(in, member, value)
#define ROW_MAYBE(name, of, in, member, value) \
	.key = name, .type = of, .form = ROW_POINTER, .size = sizeof(value), .at = ROW_AT(in, member, value *)
#define ROW_MANY(name, of, in, member, value, few, many) \
	.key = name, .type = of, .form = ROW_LIST, .size = sizeof(value), .at = ROW_AT(in, member, __typeof__(value) *), \
	.count_at = ROW_AT(in, member##_count, uint32_t), .least = few, .most = many

/* A member of type double *, int64_t *, bool *, int * (an enum), char *; NEEDED_: double, int64_t, int, char *. */
#define NUMBER(name, in, member) ROW_MAYBE(name, ROW_NUMBER, in, member, double)
#define NEEDED_NUMBER(name, in, member) ROW_ONE(name, ROW_NUMBER, ROW_HERE, in, member, double), .needed = true
#define WHOLE(name, in, member) ROW_MAYBE(name, ROW_WHOLE, in, member, int64_t)
#define NEEDED_WHOLE(name, in, member) ROW_ONE(name, ROW_WHOLE, ROW_HERE, in, member, int64_t), .needed = true
#define SWITCH(name, in, member) ROW_MAYBE(name, ROW_SWITCH, in, member, bool)
#define WORD(name, in, member, list) ROW_MAYBE(name, ROW_WORD, in, member, int), .words = list
#define NEEDED_WORD(name, in, member, list) ROW_ONE(name, ROW_WORD, ROW_HERE, in, member, int), .words = list, .needed = true
#define TEXT(name, in, member, bytes) ROW_ONE(name, ROW_TEXT, ROW_HERE, in, member, char *), .longest = bytes
#define NEEDED_TEXT(name, in, member, bytes) TEXT(name, in, member, bytes), .needed = true
/* A mapping: a pointer to `inner`; NEEDED_: `inner` itself. */
#define MAPPING(name, in, member, inner, list) ROW_MAYBE(name, ROW_MAPPING, in, member, inner), .rows = list
#define NEEDED_MAPPING(name, in, member, inner, list) ROW_ONE(name, ROW_MAPPING, ROW_HERE, in, member, inner), .rows = list, .needed = true
/* Lists: a pointer, and its count in MEMBER_count; NEEDED_: an array of `count` in the struct. */
#define NUMBERS(name, in, member, few, many) ROW_MANY(name, ROW_NUMBER, in, member, double, few, many)
#define NEEDED_NUMBERS(name, in, member, count) \
	.key = name, .type = ROW_NUMBER, .form = ROW_FIXED, .size = sizeof(double), .at = ROW_AT(in, member, double[count]), .least = count, .most = count, \
	.needed = true
#define WHOLES(name, in, member, few, many) ROW_MANY(name, ROW_WHOLE, in, member, int64_t, few, many)
#define PAIRS(name, in, member, few, many) ROW_MANY(name, ROW_NUMBER, in, member, double[2], few, many), .each = 2
#define TEXTS(name, in, member, bytes, few, many) ROW_MANY(name, ROW_TEXT, in, member, char *, few, many), .longest = bytes
#define MAPPINGS(name, in, member, inner, list, few, many) ROW_MANY(name, ROW_MAPPING, in, member, inner, few, many), .rows = list

#define RANGE(least_number, most_number) .low = least_number, .high = most_number
#define ABOVE(least_number, most_number) .low = least_number, .high = most_number, .above = true
#define DEFAULT(number) .has_default = true, .absent = number

/* --- reading the rows --- */

/* A walk over the rows of a mapping, in their order; included rows are walked where they stand. */
struct scene_rows {
	const struct scene_row *next[4];
	int depth;
};
struct scene_rows scene_rows_begin(const struct scene_row *rows);
const struct scene_row *scene_rows_next(struct scene_rows *walk); /* NULL: there is no other row */

/* The row of a key in a mapping, or NULL. The key ends at `length`. */
const struct scene_row *scene_row_find(const struct scene_row *rows, const char *key, size_t length);
/* The row at a path with [] in place of indices, such as "objects[].shape.box.size[]", or NULL. *entry: the path ends in as many [] as the row
 * has lists, so it means an entry. */
const struct scene_row *scene_row_at(const char *path, bool *entry);
/* Lists in lists: 0 for a single value or a mapping. */
int scene_row_lists(const struct scene_row *row);

/* Visits every row, depth first, in the order of the table. `path`: with [] in place of indices; it is valid during the call. Rows that several
 * mappings share (those of a soil) are visited once, below the first. Returns what a visit returned first that is not STATUS_OK. */
typedef enum status (*scene_row_visit_fn)(void *user, const char *path, const struct scene_row *row);
enum status scene_row_visit(scene_row_visit_fn visit, void *user) FURROW_CHECKED;

/* The default of the number at a path. The number must have one. */
double scene_absent(const char *path);

extern const struct scene_row scene_schema[]; /* of the scene itself */

#endif
