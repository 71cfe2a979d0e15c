/*
 * A plan: the resources that a drive will make and the passes that it will run, known before it begins.
 *
 * Each part of Furrow adds the lines of what it will use, beside the code that uses it. A line is an amount for each one of a
 * unit: two passes a window, 20 bytes a post, a program once. The counts at a drive's end equal the lines' amounts times the
 * units' counts. Nothing else was made or run (law 7). Pure: no GL, no store. One thread at a time.
 */
#ifndef FURROW_BASE_PLAN_H
#define FURROW_BASE_PLAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

enum plan_kind {
	PLAN_PLANE,     /* what is kept a post; bytes: of one */
	PLAN_PROGRAM,   /* linked; the name is its key: files, then defines */
	PLAN_PASS,      /* amount: how many a unit; the name is the stage it counts as */
	PLAN_TEXTURE,   /* amount and bytes a unit */
	PLAN_BUFFER,    /* the same, of GL's buffers and of staging memory */
	PLAN_THREAD,    /* amount */
	PLAN_STATEMENT, /* of SQLite, executed; amount a unit; the name is "read" or "write" and the table's */
	PLAN_KINDS
};

/* The units of amounts. All of them except PLAN_ONCE are counted in a drive. */
enum plan_unit {
	PLAN_ONCE,
	/* memory: the most that existed at once */
	PLAN_BASE_SLOT,    /* slots that a tile was ever loaded to */
	PLAN_CLASS_SLOT,   /* those with classes of soil */
	PLAN_DEFORM_SLOT,  /* deform slots, with the planes that are drawn */
	PLAN_STATE_SLOT,   /* those of them with the planes of the working level */
	PLAN_PATCH,        /* textures that bases are interpolated from */
	PLAN_PAGE,         /* images of pages on their way to slots and from them */
	PLAN_WINDOW_LAYER, /* windows that one contact needs at once */
	PLAN_RESULT_LAYER, /* results of blocks that relax, before they are copied */
	PLAN_RING,         /* segments of the ring of pass parameters */
	/* work */
	PLAN_WINDOW,       /* windows of an object that were computed */
	PLAN_MOVED,        /* windows of them over which it moved */
	PLAN_FACETS,       /* draws of an object's triangles */
	PLAN_HELD,         /* blocks of relaxing soil, once for every object at rest there */
	PLAN_RESTING,      /* windows of such objects for which a lower envelope was drawn */
	PLAN_ATLAS,        /* atlases of blocks that relaxed */
	PLAN_DECIMATED,    /* updates of coarser tiles after a change */
	PLAN_SUBDIVIDED,   /* bases interpolated */
	PLAN_DRAWN,        /* tiles in pictures */
	PLAN_OBJECTS,      /* draws of objects in pictures; one draws all of one shape and detail */
	PLAN_SHADOWED,     /* pictures in which objects cast shadows */
	PLAN_FRAME,
	PLAN_LOADED,       /* tiles of the working level whose planes were read */
	PLAN_LOADED_COARSER, /* coarser ones */
	PLAN_READ,         /* bases read, by anybody */
	PLAN_RANGE,        /* ranges of bases, to cull by, and how far off coarser ones are */
	PLAN_OFFSET_RANGE, /* ranges of offsets: how far the ground is from its base */
	PLAN_COMMITTED,    /* tiles of the working level in commits */
	PLAN_COMMITTED_COARSER, /* tiles above them, whose offsets followed */
	PLAN_CHANGED,      /* rows of the line's table that commits changed; an unchanged row is not written */
	PLAN_LEFT,         /* rows of the line's table that were looked up because an earlier drive may have left them */
	PLAN_COMMIT,
	PLAN_UNITS
};

struct plan_line {
	enum plan_kind kind;
	enum plan_unit unit;
	const char *effect; /* name of the effect that needs it (table of scene.h); NULL: every drive needs it */
	int object;         /* object of the scene whose units count; -1: all */
	int64_t amount;
	uint64_t bytes;
	char name[96];
};

/* Lines in the order they were added. A plan that ran out of memory says so at the end: plan_status. */
struct plan {
	struct plan_line *lines;
	size_t count, room;
	bool failed;
};

/* The name is cut to what fits. A program, plane or thread of a name that is there already is not added again. */
void plan_add(struct plan *plan, const struct plan_line *line, const char *name);
enum status plan_status(const struct plan *plan) FURROW_CHECKED;
void plan_finish(struct plan *plan); /* of one that is all zero too */

const char *plan_kind_name(enum plan_kind kind);
const char *plan_unit_name(enum plan_unit unit); /* "once", "base_slot", .. */

#endif
