/*
 * A plan: the resources that a drive will make and the passes that it will run, known before it begins.
 *
 * Each part of Furrow adds lines for what it will use, in the same file as the code that uses it. A line is an amount for each
 * unit: two passes for each window, 20 bytes for each post, a program once. At a drive's end, every count equals the sum of its
 * lines: amount times number of units. Nothing else was made or run (law 7). Pure: no GL, no store. One thread at a time.
 */
#ifndef FURROW_BASE_PLAN_H
#define FURROW_BASE_PLAN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

enum plan_kind {
	PLAN_PLANE,     /* a value kept for each post; bytes: size of one value */
	PLAN_PROGRAM,   /* a linked program; name: its shader files, then its defines */
	PLAN_PASS,      /* amount: passes for each unit; name: the stage under which they are counted */
	PLAN_TEXTURE,   /* amount: textures for each unit; bytes: size of one */
	PLAN_BUFFER,    /* amount: buffers of GL and staging buffers for each unit; bytes: size of one */
	PLAN_THREAD,    /* amount: threads */
	PLAN_STATEMENT, /* amount: SQLite statements executed for each unit; name: "read" or "write", and the table */
	PLAN_KINDS
};

/* The unit of a line: what its amount is multiplied by. A drive counts all units except PLAN_ONCE, which is 1. */
enum plan_unit {
	PLAN_ONCE,
	/* Units of memory. A drive counts how many of them existed at the same time, at most. */
	PLAN_BASE_SLOT,    /* base slots into which a tile was loaded at least once */
	PLAN_CLASS_SLOT,   /* base slots that also have soil classes */
	PLAN_DEFORM_SLOT,  /* deform slots with the drawn planes */
	PLAN_STATE_SLOT,   /* deform slots that also have the planes of the soil's state */
	PLAN_BASE_ARRAY,   /* arrays of which bases are layers, if contacts are computed together */
	PLAN_BASE_LAYER,   /* their layers */
	PLAN_DEFORM_ARRAY, /* arrays of which one drawn plane of deform slots is a layer */
	PLAN_DEFORM_LAYER, /* their layers */
	PLAN_PATCH,        /* textures from which base heights are interpolated */
	PLAN_PAGE,         /* copies of pages in main memory, while they are loaded or committed */
	PLAN_WINDOW_LAYER, /* windows that one contact needs at once */
	PLAN_RESULT_LAYER, /* results of blocks that relax, before they are copied */
	PLAN_RING,         /* segments of the ring of pass parameters */
	PLAN_HOST_BASE,    /* tiles in host memory that have base heights */
	PLAN_HOST_CLASSES, /* of these, those that also have soil classes */
	PLAN_HOST_NUMBERS, /* and numbers of the soil, from rasters */
	/* planes of tiles in host memory, in the order of enum plane: PLAN_HOST_OFFSET + plane */
	PLAN_HOST_OFFSET, PLAN_HOST_DISTURBANCE, PLAN_HOST_DEPOSITED, PLAN_HOST_SINKAGE, PLAN_HOST_SHEAR, PLAN_HOST_DUG, PLAN_HOST_SETTLED, PLAN_HOST_LOOSE,
	PLAN_HOST_FLOOR, PLAN_HOST_DENSITY, PLAN_HOST_SLOPE, PLAN_HOST_HEALED, PLAN_HOST_RISEN, PLAN_HOST_GROWN,
	PLAN_WINDOW_POST,  /* posts for which the window of bearing soil has room */
	PLAN_WINDOW_SCRATCH, /* bytes of scratch memory beside that window, for laying and sliding */
	PLAN_RESULT_POST,  /* posts of relaxing bearing soil that were computed, before they are put back */
	/* units of work; counted over the whole drive */
	PLAN_WINDOW,       /* windows of an object that were computed alone */
	PLAN_MOVED,        /* of these, windows in which the object moved */
	PLAN_BATCH,        /* batches of windows that were computed together */
	PLAN_BATCH_DRAW,   /* draws in them of the ground, one for each pair of arrays, and of contacts, for each kind of body too */
	PLAN_BATCH_STORE,  /* draws in them that write tiles: one for each array */
	PLAN_BATCH_ENVELOPE, /* draws of lower envelopes in them */
	PLAN_FACETS,       /* draws of an object's triangles */
	PLAN_HELD,         /* blocks of relaxing soil with objects at rest, counted once for each object */
	PLAN_RESTING,      /* windows of objects at rest for which a lower envelope was drawn */
	PLAN_ATLAS,        /* atlases of blocks that relaxed */
	PLAN_DECIMATED,    /* updates of coarser tiles after a change */
	PLAN_SUBDIVIDED,   /* base tiles interpolated */
	PLAN_DRAWN,        /* tiles in pictures */
	PLAN_OBJECTS,      /* draws of objects in pictures; one draw shows all objects of one shape and detail */
	PLAN_SHADOWED,     /* pictures in which objects cast shadows */
	PLAN_FRAME,        /* pictures */
	PLAN_LOADED,       /* tiles of the working level whose planes were read */
	PLAN_LOADED_COARSER, /* coarser tiles whose planes were read */
	PLAN_READ,         /* base tiles read, by any thread */
	PLAN_RANGE,        /* ranges of base heights, for culling, and errors of coarser levels */
	PLAN_OFFSET_RANGE, /* ranges of offsets: bounds of the ground above and below its base */
	PLAN_COMMITTED,    /* tiles of the working level in commits */
	PLAN_COMMITTED_COARSER, /* coarser tiles that were updated with them */
	PLAN_CHANGED,      /* rows of the line's table that commits changed; an unchanged row is not written */
	PLAN_LEFT,         /* rows of the line's table that were looked up because an earlier drive may have left them */
	PLAN_INHERITED,    /* further reads of the line's table by an overlay: of rows that only a file under it has */
	PLAN_KEPT,         /* rows of the line's table that commits put into a history; rows of the history itself; revisions */
	PLAN_SOUGHT,       /* rows that commits looked for in a history */
	PLAN_COMMIT,       /* commits */
	PLAN_UNITS
};

struct plan_line {
	enum plan_kind kind;
	enum plan_unit unit;
	const char *effect; /* name of the effect that needs this line (table of scene.h); NULL: every drive needs it */
	int object;         /* index of the scene's object whose units count; -1: all */
	int64_t amount;
	uint64_t bytes;
	char name[128];
};

/* Lines in the order in which they were added. If memory ran out, plan_status returns the failure. */
struct plan {
	struct plan_line *lines;
	size_t count, room;
	bool failed;
};

/* Adds a line. The name is cut if it does not fit. A program, plane or thread whose name is already in the plan is not added
 * again. */
void plan_add(struct plan *plan, const struct plan_line *line, const char *name);
enum status plan_status(const struct plan *plan) FURROW_CHECKED;
void plan_finish(struct plan *plan); /* the plan may be all zero */

const char *plan_kind_name(enum plan_kind kind);
const char *plan_unit_name(enum plan_unit unit); /* "once", "base_slot", .. */

#endif
