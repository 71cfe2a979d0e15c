/* What the files view*.c share. Only the world's thread touches it. */
#ifndef FURROW_RENDER_VIEW_H
#define FURROW_RENDER_VIEW_H

#include "render/render.h"
#include "base/key_map.h"
#include "base/key_set.h"
#include "terrain/terrain.h"

/* What the picture of one time needs: tiles, in the order of need. */
struct view_look {
	double time; /* simulated, s */
	double made; /* when it was looked at; simulated, s */
	bool guessed; /* ranges were missing */
	uint64_t done; /* ranges that had been brought by then */
	size_t count;
	uint64_t keys[2 * TERRAIN_DRAWS_MAX];
};

#define VIEW_LOOKS 4 /* times looked ahead to */
#define VIEW_MISSING 1024

struct view_errors; /* view_errors.c */

struct view_contact {
	bool known;       /* no offset it leaves is below `low` or above `high`; else they are as far as objects reach */
	double low, high; /* 0 or less, 0 or more; metres */
};

struct view {
	struct world *world;
	bool watched;             /* somebody looks at every picture */
	bool at_steps;            /* only every scene.view.images-th step has a picture; else any step may have one */
	uint64_t frames;          /* drawn */
	struct render *render;
	struct key_set deformed;  /* tiles that had offset tiles at or below them before the drive; 11 to 21 bytes each */
	struct offset_bounds bounds; /* what this drive's contacts may have left, of each tile that they changed */
	struct view_contact contact; /* what this one may leave */
	struct key_set expected;  /* tiles that will be deformed, and all above them; empty but while looking ahead */
	struct key_cache ranges;  /* of bases; a: NaN where nothing is */
	double reach;             /* metres that an unknown result of a contact may be off what was there */
	struct view_errors *errors; /* NULL: detail goes by the radii */
	size_t budget;            /* slots one picture may need */
	size_t room;              /* slots this picture and those ahead may need together */
	bool exact;               /* missing ranges are read now; else the look-ahead's thread reads them, and others are used meanwhile */
	bool guessed;             /* the last selection used such other ranges */
	struct ground_range_key *missing; /* ranges to ask for, VIEW_MISSING at most */
	size_t missing_count;
	bool coarse;              /* the last selection was cut to the budget; only for figures */
	bool told;
	bool free;                /* a host has the camera: */
	struct render_camera camera;
	bool lacks;               /* the last picture wanted tiles that had not come */
	struct terrain_selection *selection;
	struct view_look *now;    /* the last picture */
	struct view_look *ahead;  /* VIEW_LOOKS of them, each replaced in turn */
	unsigned turn;
	struct key_set seen;      /* used while requests are put together */
	uint64_t naps;            /* pictures that waited for their tiles */
	double nap_ms;            /* their time without waits for the store, which are counted elsewhere */
	uint64_t starved;         /* frames drawn coarser than asked for, for any reason */
	uint64_t coarsened;       /* of those: the budget was the reason */
	double triangles;         /* summed over frames */
	struct render_tiles tiles; /* the same */
	double overdraw;          /* the same, over frames whose overdraw is known */
	uint64_t overdraw_frames;
	enum status failed;       /* of a source callback */
};

/* view_camera.c */
/* If the view is not exact, the camera may be off in height, since nothing is waited for. */
void render_view_place_camera(struct view *view, double time, struct render_camera *camera);

/* view_objects.c: tells the picture where the objects are now. `settled`: waits for the heights of loaded bodies, so that the
 * picture is always the same. Otherwise uses the heights known last. */
enum status render_view_set_objects(struct view *view, bool settled) FURROW_CHECKED;

/* view_ranges.c: ranges of tiles, exact or as those of the tiles above them. */
/* Returns true if this range is not on the CPU and must not be read now. Then it is noted as missing; the caller uses another. */
bool render_view_lacks_range(struct view *view, enum ground_range_kind kind, struct tile tile);
/* Returns true if the range of this tile is on the CPU. */
bool render_view_has_range(struct view *view, enum ground_range_kind kind, struct tile tile);
/* Hands the missing ranges to the look-ahead. */
void render_view_ask_ranges(struct view *view);
/* Adds the ranges of tiles that contacts will change and that were deformed before the drive. */
void render_view_expect_contacts(struct view *view);

/* view_source.c */
void render_view_find_room(struct view *view);
/* Finds the lowest (a) and highest (b) base, metres; a NaN: all is nodata. If the view is not exact, it may be of a tile above. */
enum status render_view_base_range(struct view *view, struct tile tile, struct key_pair *range) FURROW_CHECKED;
/* Adds a tile and all above it. */
enum status render_view_add_chain(const struct view *view, struct key_set *set, struct tile tile) FURROW_CHECKED;
/* Selects what `camera` sees, cut to the budget. `everything`: as if no tile were resident, so that the wanted tiles are the whole
 * picture. Marks no tile as used. */
enum status render_view_select(struct view *view, const struct render_camera *camera, bool everything) FURROW_CHECKED;
/* Marks the selected tiles as used. Without `stand_ins` only those that the complete picture needs. */
void render_view_mark_used(struct view *view, bool stand_ins);

/* view_offsets.c: how far off its base a tile's surface may be. */
bool render_view_is_deformed(const struct view *view, struct tile tile); /* it or a tile below it has offsets */
double render_view_find_reach(const struct world *world);
/* Finds the range that the store had at the drive's start, metres: 0 or less to 0 or more. If the view is not exact, it may be that
 * of a tile above. */
enum status render_view_stored_offsets(struct view *view, struct tile tile, double *low, double *high) FURROW_CHECKED;
/* For render_view_contact. */
enum status render_view_offsets_contact(struct view *view, const struct contact_area *area) FURROW_CHECKED;
/* Says that the contact of now changes a tile of the working level. */
enum status render_view_offsets_touch(struct view *view, struct tile tile) FURROW_CHECKED;
/* Finds a range, metres, that all offsets of the tile's subtree are within. `expected`: also those that the drive will have made by
 * the time that is looked at. */
enum status render_view_offsets(struct view *view, struct tile tile, bool expected, double *low, double *high) FURROW_CHECKED;

/* view_errors.c: how far off the ground a tile is drawn. Only with a pixel error. */
enum status render_view_errors_create(const struct world *world, struct view_errors **out) FURROW_CHECKED;
void render_view_errors_destroy(struct view_errors *errors); /* takes NULL */
/* For render_view_contact. */
enum status render_view_errors_contact(struct view *view, const struct event *event) FURROW_CHECKED;
/* Says that the contact of now changes a tile of the working level. */
enum status render_view_errors_touch(struct view *view, struct tile tile) FURROW_CHECKED;
/* Finds the error, metres, for terrain_source.error. `expected`: the tile will be deformed by the time that is looked at. */
enum status render_view_error(struct view *view, struct tile tile, bool expected, double *error) FURROW_CHECKED;

/* view_ahead.c: what pictures will need. */
void render_view_keep_now(struct view *view);
/* Looks at one of the times ahead; call once a frame, after it was selected and kept. */
enum status render_view_look_ahead(struct view *view) FURROW_CHECKED;

#endif
