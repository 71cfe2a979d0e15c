/* Shared by the files of src/deform: the struct deform, its textures, and the functions that one file offers to the others. */
#ifndef FURROW_DEFORM_INTERNAL_H
#define FURROW_DEFORM_INTERNAL_H

#include "deform/deform.h"
#include "deform/programs.h"
#include "soil/kinematic/kinematic.h"
#include "soil/kinematic/shed.h"
#include "soil/laying/laying.h"
#include "soil/shape/affine.h"

#define SIDE DEFORM_WINDOW_POSTS
#define WARM_FACTS 3 /* besides the shape, that decide which programs an object needs */
#define UNDER_NONE INT32_MAX /* lib/window.glsl: the object is not above the post */

/* FBOs over one layer of the scratch textures. FBOs that the parameters do not need are NULL. */
enum scratch_target {
	TO_UNDER,   /* under, rest */
	TO_FREED,   /* sheet: floor plane 1 */
	TO_CONTACT, /* the textures that the model's contact pass writes */
	TO_FIRST,   /* box: offset plane 0 */
	TO_SECOND,  /* box: offset plane 1 */
	TO_BEGUN,   /* the start of sliding: heights, and the other textures that sliding starts with */
	TO_HEIGHTS_0, TO_HEIGHTS_1,
	TO_SHED,    /* sumner: the soil that each post sheds, in the texture `carried` */
	/* Hops along slopes, in the atlas. The first writes heights to `carried` and extents to `deposits`. Later hops write extents in
	 * turn to `under` and to `deposits`. */
	TO_SLOPES_FIRST, TO_SLOPES_0, TO_SLOPES_1,
	TO_DISTURBANCE, /* disturbance plane 1 */
	TO_MARKS,       /* the planes 1 of marks that fade */
	TO_HELD,    /* only the texture `contacts` */
	TO_BARE,    /* no attachment: the pass writes images and buffers */
	SCRATCH_TARGETS
};

/* The render targets and the state of one window. Each window is computed in its own layer of the textures. */
struct layer {
	struct gpu_target *to[SCRATCH_TARGETS];
	int now[PLANES]; /* for each plane: 0 or 1, the one of planes_of[0 .. 1] that holds the newest result */
	bool near;       /* soil slides only near what the contact reached */
	bool alone;      /* the contact has only this window */
	bool above;      /* as `above` in struct deform_contact: the object is above all ground */
	bool roofed;     /* bodies at rest are near: `roofs` has theirs */
	bool flagged;    /* sliding wrote flags for this window, which tell where soil still moves */
};

struct deform;

struct batch;
struct slide_place;

/* A rule by which soil slides (soil/slide.c). The row of a model that conserves soil points to one. */
struct soil_slide {
	const char *effect; /* name of its effect */
	/* number of passes in one iteration. In one iteration the soil of a post depends on posts up to that many posts away */
	int pass_count;
	enum slide_what passes[2];
	bool bounded;       /* the layer of soil that can relax may have a bottom */
	bool held_still;    /* soil below an object does not slide */
	enum status (*iterate)(struct deform *deform, const struct slide_place *place, int iteration);
};
extern const struct soil_slide deform_slide_excess; /* a part of the height difference above the critical one slides */
/* Sumner's rule: a post that is steep sheds soil to lower posts, by the soil's roughness */
extern const struct soil_slide deform_slide_shed;

/* The limits by which a soil of sumner slides. Each is the largest height difference between two posts that is stable, and the tolerance,
 * fixed-point units. Index 0: neighbours along x or y. Index 1: diagonal neighbours. */
struct shed_soil {
	int32_t critical[2];
	int32_t held[2];   /* if an object holds one of the two posts */
	int32_t stop[2];   /* a post sheds no soil if no difference to a neighbour exceeds this */
	/* the share of the differences that moves, in 2^-32. Index: number of lower neighbours, 1 .. 8, minus 1 */
	uint32_t share[8];
};

struct deform {
	struct deform_params params;
	unsigned planes; /* deform_planes() that contacts read and write */
	double spacing;
	int64_t reach;  /* how many posts around the footprint a contact can change */
	int64_t border; /* how many more posts around these a contact reads */
	uint32_t layers; /* number of layers in the textures; each holds one window */
	uint32_t side;   /* posts along a side of these textures: SIDE, or more for a window in parts */
	struct gpu_texture *bases;
	/* lower envelopes: `under` of the whole motion, `rest` of the end pose. rest is NULL if the model does not need it */
	struct gpu_texture *under, *rest;
	/* what a contact did to each post: the bits LOWERED, HELD. NULL if no pass needs them */
	struct gpu_texture *contacts;
	struct gpu_texture *bent, *holders; /* sheet: deflections, and what holds posts down (lib/sheet.glsl) */
	struct gpu_texture *carried, *deposits; /* conserving models: soil before and after deform_spread, fixed-point units */
	/* used only while soil slides. floors is NULL if the relaxing soil has no bottom */
	struct gpu_texture *heights[2], *stills, *floors;
	struct gpu_texture *roofs;             /* how high soil may bring posts below bodies at rest; NULL: no body is */
	struct gpu_texture *classes;           /* the class of soil of each post; NULL if there is only one soil */
	/* two textures for each plane, since a pass reads one and writes the other. A gather writes the first; of the atlas, the second */
	struct gpu_texture *planes_of[2][PLANES];
	/* index `layers`: the atlas, in which blocks relax. Only models that conserve soil have it */
	struct layer scratch[DEFORM_WINDOWS_MAX + 1];
	struct active *active;                 /* active blocks; NULL: the model does not conserve soil */
	struct interval *interval;
	struct batch *batch;                   /* batch.c; NULL: every window is computed alone */
	struct gpu_program *under_program[2 * SOIL_SHAPES]; /* every program is linked when it is first needed */
	struct gpu_program *box, *contact, *disturbance, *marks;
	struct gpu_program *fixed[FIXED_PASSES];
	struct gpu_program *sheet[SHEET_PASSES];
	struct gpu_program *spread[SPREAD_PASSES];
	struct gpu_program *held, *roof[ROOF_PASSES];
	struct gpu_program *facet;
	struct facets *facets;                 /* triangles of meshes and grousers; made when first needed */
	struct gpu_program *slide_begin[OVERS]; /* index: enum deform_over */
	struct gpu_program *slide[2][OVERS][2], *shed[2][OVERS]; /* indices: 1: below roofs; enum deform_over; 1 in the last iteration */
	struct gpu_program *lines[2];          /* index: 1: diagonal ones */
	struct gpu_program *slope[SLOPE_HOPS], *steep;
	struct soil_sliding sliding;           /* the rule of all models but sumner; of sumner its tolerance */
	struct shed_soil soils[SOIL_CLASSES];  /* sumner */
	struct soil_shed sheds;                /* the same rule as the CPU takes it: sliding.shed */
	bool contacts_flag;                    /* the flags that a contact writes show all blocks where soil moves after it */
	struct gpu_buffer *laying;             /* soil/spread.c: what its passes hand on; NULL: the model does not conserve soil */
	struct gpu_buffer *tally;              /* counts on the GPU: a struct deform_tally */
	struct deform_figures figures;         /* its window_layers is unused: see `layers` */
	bool warmed[SOIL_SHAPES << WARM_FACTS]; /* kinds of objects whose programs deform_warm has prepared (warm.c) */
};

/* scratch.c: makes textures and render targets for at least `layers` windows, of at least `side` posts on a side. */
enum status deform_need_layers(struct deform *deform, uint32_t layers, uint32_t side) FURROW_CHECKED;
uint64_t deform_scratch_layers(const struct deform *deform); /* how many layers of SIDE posts hold as many posts, less the atlas */
void deform_drop_layers(struct deform *deform);
void deform_scratch_plan(const struct deform_params *params, struct plan *plan);

/* Each returns a property of the deform that depends on its parameters only. */
bool deform_needs_contacts(const struct deform_params *params); /* scratch.c */
bool deform_has_classes(const struct deform_params *params);
const char *deform_marks_effect(const struct deform_params *params); /* stages.c: whose pass it is that writes marks that fade */
int deform_soil_slots(const struct deform_params *params); /* soil/slide.c: classes of soil that a shader's parameters have room for */
bool deform_is_bounded(const struct deform_params *params); /* the layer of soil that can relax has a bottom */
/* the height difference of two posts may not fit 32 bits: the relief exceeds SOIL_STEEP_RELIEF */
bool deform_is_steep(const struct deform_params *params);
bool deform_has_slopes(const struct deform_params *params); /* a soil's limit depends on the height of the slope */
bool deform_asks_what_stood(const struct deform_params *params); /* sliding must compare with the undisturbed ground */
int deform_slide_passes(const struct deform_params *params, bool blocks); /* over blocks, or over a window */
int64_t deform_reach(const struct deform_params *params);  /* windows.c: struct deform's reach and border */
int64_t deform_border(const struct deform_params *params);
int64_t deform_core(const struct deform_params *params);   /* the most posts that a window writes along one side */

/* Makes the program at *place if it is not there yet. */
enum status deform_program(struct deform *deform, const struct deform_request *request,
			   struct gpu_program **place) FURROW_CHECKED;

/* Adds a line to the plan, for a buffer or staging buffer that all objects share. `amount`: how many such buffers. `bytes`: of all
 * of them together. */
void deform_plan_buffer(struct plan *plan, const char *effect, int64_t amount, uint64_t bytes, const char *name);

/* std140 twins of the first parameters of most passes over a window. */
struct window_params {
	int32_t window[4]; /* posts in x and y; the layer */
};
struct contact_params {
	uint32_t zero[4];   /* lo, hi: the window's zero height, fixed-point units from the store's reference; the layer */
	int32_t written[4]; /* the posts this window writes: first, one behind the last */
};
struct contact_params deform_contact_params(const struct deform *deform, const struct deform_contact *contact,
					const struct deform_window *window, uint32_t layer);
struct window_params deform_window_params(struct post_rect read, uint32_t layer);

/* Returns the written posts, in the window's layer. */
struct gpu_rect deform_written(const struct deform_window *window);
/* Fills a rectangle of posts as passes take it: the first post, one behind the last. */
void deform_posts_of(struct gpu_rect rect, int32_t posts[4]);
/* Fills where posts lie in a window, counted from its first post: the first of them, one behind the last. */
void deform_posts_in(const struct deform_window *window, struct post_rect posts, int32_t in[4]);
/* Returns all posts of the window, in its layer. */
struct gpu_rect deform_window_rect(const struct deform_window *window);

/* shape/envelope.c: draws the object's lower envelope over the window into `under` and `rest`. deform_envelope_is_brief: returns
 * true if the parameters are few enough for passed.vert. */
#define DEFORM_BRIEF_BYTES 224
bool deform_envelope_is_brief(enum soil_shape_kind kind, bool sideways);
enum status deform_envelope(struct deform *deform, const struct deform_contact *contact,
			     const struct deform_window *window, uint32_t layer) FURROW_CHECKED;
/* What that draws for a closed form. deform_under_of: computes it for posts that are counted from post (x0, y0). deform_under_run: draws it
 * over posts of a layer. */
struct under_params {
	struct body motion, end; /* std140 twin of the uniform block in lib/envelope.glsl */
	enum soil_shape_kind kind;
	bool sideways;
};
void deform_under_of(const struct deform *deform, const struct deform_contact *contact, int64_t x0, int64_t y0, struct under_params *params);
enum status deform_under_run(struct deform *deform, const struct under_params *params, struct gpu_rect posts, uint32_t layer) FURROW_CHECKED;

/* shape/facets.c: draws moving triangles over a window into `under` and `rest`; the lowest height is kept. Begin, add facets,
 * and end, for one window at a time. */
struct facet;
struct facets_motion;
enum status deform_facets_begin(struct deform *deform, struct post_rect read, uint32_t layer) FURROW_CHECKED;
/* Adds a facet: a facets_fn. user: the struct deform. */
void deform_facets_add(void *user, const struct facet *facet);
void deform_facets_end(struct deform *deform);
void deform_facets_plan(const char *effect, struct plan *plan);
void deform_facets_destroy(struct facets *facets);

/* shape/mesh.c: returns the motion over a window whose facets are drawn. */
struct facets_motion deform_facets_motion(const struct deform *deform, const struct deform_contact *contact, const struct deform_window *window);

/* shape/mesh.c: draws a mesh's lower envelope over the window. */
enum status deform_mesh(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			uint32_t layer) FURROW_CHECKED;

/* shape/grousers.c: draws a wheel's grousers over the window. The smooth wheel must be drawn before. */
enum status deform_grousers(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
			uint32_t layer) FURROW_CHECKED;

/* stages.c: runs the contact pass of a model that writes TO_CONTACT. Its parameters begin with struct contact_params. */
enum status deform_run_contact(struct deform *deform, const void *params, size_t params_bytes,
			 const struct deform_window *window, uint32_t layer) FURROW_CHECKED;

/* stages.c: runs the contact pass of a model whose parameters are only struct contact_params. */
enum status deform_contact_plainly(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window,
				   uint32_t layer) FURROW_CHECKED;

/* soil/sheet.c: tells how an elastic sheet bends; in how many passes; and which posts around a contact's shadow may change. */
struct soil_sheet deform_sheet(const struct deform_params *params);
int deform_sheet_passes(const struct deform_params *params);
struct post_rect deform_sheet_changes(const struct deform_params *params, struct post_rect shadow);

/* soil/spread.c: returns the viewport of a pass with one invocation for each row of `posts`. The rows lie DEFORM_ROWS_ABREAST side by side. */
#define DEFORM_ROWS_ABREAST 4
struct gpu_rect deform_rows(const int32_t posts[4]);

/* windows.c: returns the shadow of a contact: all posts that the object can be above while it moves. */
struct post_rect deform_shadow(const struct deform *deform, const struct deform_contact *contact);
/* deform_reached: returns the posts that a contact can change. deform_whole: returns the window of which this one is a part. */
struct post_rect deform_reached(const struct deform *deform, const struct deform_contact *contact);
/* Returns true if the object did not jump, and its attitude hardly changed. So during the contact it was less than two spacings above, or
 * beside, each post on which it lay before. */
bool deform_is_swept(const struct deform *deform, const struct deform_contact *contact);
struct deform_window deform_whole(const struct deform *deform, const struct deform_window *window);

/* soil/spread.c: lays displaced soil down around the object, in `deposits`. The contact pass wrote `carried`, at most 2^23 fixed-point
 * units a post.
 * deform_spread_params: computes how the soil of a contact is laid. deform_spread_posts: the shadow, and all posts on which soil may be
 * laid. */
struct spread_params { /* std140 twin of lib/spread.glsl's block */
	int32_t place[4], written[4], shadow[4], origin[4], axis[4], shares[4], soils[SOIL_CLASSES][4];
};
/* deform_laying: tells how a contact lays soil. deform_laid: how each soil is laid. */
struct soil_laying deform_laying(const struct deform *deform, const struct deform_contact *contact);
void deform_laid(const struct deform *deform, struct soil_laid soils[SOIL_CLASSES]);
struct spread_params deform_spread_params(const struct deform *deform, const struct deform_contact *contact,
					  const struct deform_window *window, uint32_t layer);
enum status deform_spread(struct deform *deform, const struct deform_contact *contact, const struct spread_params *params, const struct deform_window *window,
			  uint32_t layer) FURROW_CHECKED;
double deform_spread_band(const struct deform *deform, const struct soil_shape *shape); /* posts: how wide it is at most; 0: none is laid */
struct post_rect deform_spread_posts(const struct deform *deform, const struct deform_contact *contact, struct post_rect shadow);
enum status deform_spread_create(struct deform *deform) FURROW_CHECKED;
void deform_spread_plan(struct plan *plan);

/* soil/slide.c: adds the deposits to the ground. Then applies the model's relaxation rule `iterations` times to the window's
 * written posts. Reads offsets and deposited thickness from planes_of[1], and leaves them there. */
enum status deform_slide(struct deform *deform, const struct deform_window *window, uint32_t layer) FURROW_CHECKED;
/* soil/slide.c: runs the passes after a contact that displaced soil: first the soil is spread, then it slides. */
enum status deform_spread_and_slide(struct deform *deform, const struct deform_contact *contact, const struct spread_params *spread,
				    const struct deform_window *window, uint32_t layer) FURROW_CHECKED;
/* roofs.c: bodies at rest, below which posts do not rise. All need deform_need_roofs.
 * deform_find_roofs: finds those of contact->rests over a window whose contact was computed. deform_roof_envelopes: draws both envelopes of a body over
 * these posts, in layer 0. deform_roof_note: adds the body's roofs to those of a place; drawn: the posts of the envelopes. deform_roof_run: runs another
 * pass over posts of a layer. heights: of ROOF_CLOSE and ROOF_OPEN. */
struct deform_roof_place {
	struct post_rect posts;
	uint32_t layer, x, y; /* where the first of them is */
};
void deform_clear_roofs(struct deform *deform, uint32_t layer, struct gpu_rect posts);
enum status deform_find_roofs(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window, uint32_t layer) FURROW_CHECKED;
enum status deform_roof_envelopes(struct deform *deform, const struct deform_rest *rest, struct post_rect posts) FURROW_CHECKED;
enum status deform_roof_note(struct deform *deform, const struct deform_rest *rest, struct post_rect drawn, const struct deform_roof_place *place) FURROW_CHECKED;
enum status deform_roof_run(struct deform *deform, enum roof_pass pass, struct gpu_rect posts, uint32_t layer, struct gpu_texture *heights) FURROW_CHECKED;
/* Blocks that slide together in the atlas, as rectangles of its posts. */
#define ATLAS_MOST 49 /* lib/squares.glsl */
/* Cells of the atlas that are marked, and how: lib/cells.glsl. */
#define CELL 16
#define CELLS_ACROSS (SIDE / CELL)
struct slide_atlas {
	int32_t regions[ATLAS_MOST][4]; /* of blocks, with the rim around them: first post (x, y), posts in x and y */
	int32_t blocks[ATLAS_MOST][4];  /* active ones: first post (x, y), index of its word in the flags */
	uint32_t region_count, block_count;
	struct gpu_buffer *quads;       /* indices */
	struct gpu_texture *cells;      /* marks of cells (steep.frag); NULL: the height of slopes does not count */
};
struct slide_place {
	uint32_t layer;
	struct gpu_rect all, written; /* posts that are computed; posts that exchange soil */
	int32_t around;               /* only over a window: soil slides this many posts around what the contact reached; -1: in all */
	struct post_rect first;       /* only over a window: its written posts, which decide in what order soil slides along lines */
	struct place_flags {
		struct gpu_buffer *words;
		/* Only over a window: */
		uint32_t first, columns;  /* its first word; its blocks in a row */
		int32_t from[2];          /* its first post, counted from the first post of its first block */
		int32_t step, sides[4];   /* posts beside a border, and beside each side of the window, that were not looked at */
	} flags;
	const struct slide_atlas *atlas; /* NULL over a window */
	bool roofed;                     /* bodies at rest keep posts from rising */
};
enum status deform_slide_run(struct deform *deform, const struct slide_place *place) FURROW_CHECKED;
/* Returns the place of a window. */
struct slide_place deform_slide_place(struct deform *deform, const struct deform_window *window, uint32_t layer);
/* soil/atlas.c: runs a pass at a place, and fills its viewport. Over an atlas it also fills the geometry, and the parameters before those
 * of the pass (regions.vert). It draws regions, less `trim` posts along each side; or blocks; or only cells near marked ones. */
enum atlas_part { ATLAS_REGIONS, ATLAS_BLOCKS, ATLAS_CELLS, ATLAS_BLOCK_CELLS };
void deform_atlas_run(struct deform *deform, const struct slide_place *place, enum atlas_part part, int64_t trim, const struct gpu_pass *pass);
/* soil/lines.c: soil slides along the lines of a window, before the last iteration. `heights`: index of the heights.
 */
enum status deform_lines_run(struct deform *deform, const struct slide_place *place, int heights) FURROW_CHECKED;
/* soil/slopes.c: finds the critical difference in the slope at each post, in blocks. deform_slopes_found: returns the result. */
int deform_slope_passes(const struct deform_params *params); /* 0 if the height of slopes does not count */
int64_t deform_slope_reach(const struct deform_params *params); /* returns over how many posts a slope is followed each way */
enum status deform_slopes_run(struct deform *deform, const struct slide_place *place) FURROW_CHECKED;
struct gpu_texture *deform_slopes_found(const struct deform *deform);
/* Returns how many posts around a block an interval reads. */
int64_t deform_slide_rim(const struct deform *deform);
/* Returns how many posts around a changed post the next iteration may change. */
int64_t deform_slide_step(const struct deform *deform);
/* Computes the critical differences of all soils. */
void deform_slide_prepare(struct deform *deform);

/* deform.c: deform_gather copies planes of a rectangle of posts from tiles to place (x, y) of a layer; of the atlas: into
 * planes_of[1]. deform_scatter_from copies planes back to tiles. */
void deform_gather(struct deform *deform, struct post_rect read, uint32_t layer, uint32_t x, uint32_t y, bool atlas,
		   unsigned planes, const struct tile_slot *tiles, size_t count);
/* As deform_gather, of further tiles of a rectangle that it was called for. */
void deform_gather_more(struct deform *deform, struct post_rect read, uint32_t layer, uint32_t x, uint32_t y, bool atlas,
			unsigned planes, const struct tile_slot *tiles, size_t count);
struct scatter_from {
	struct gpu_texture *planes[PLANES]; /* NULL: the tiles keep this plane */
	uint32_t layer, x, y;
};
enum status deform_scatter_from(struct deform *deform, struct post_rect write, const struct scatter_from *from,
				const struct tile_slot *tiles, size_t count) FURROW_CHECKED;

/* fixed.c: runs the programs of a contact once, over a window outside the world. */
enum status deform_fixed_warm(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window) FURROW_CHECKED;

/* batch.c */
enum status deform_batch_create(struct deform *deform) FURROW_CHECKED;
void deform_batch_destroy(struct deform *deform); /* does nothing if it was never created */
void deform_batch_plan(const struct deform_params *params, struct plan *plan);
/* For soil_batch_fn. The contact pass of a model whose parameters are only struct contact_params. After it, a pass that writes the tiles; or
 * the passes that smooth, of which the last writes the tiles. */
enum status deform_batch_contact(struct deform *deform) FURROW_CHECKED;
enum status deform_batch_store(struct deform *deform) FURROW_CHECKED;
enum status deform_batch_smooth(struct deform *deform) FURROW_CHECKED;

/* schedule/active.c */
enum status deform_active_create(struct deform *deform) FURROW_CHECKED;
void deform_active_destroy(struct active *active); /* takes NULL */
void deform_active_plan(const char *effect, struct plan *plan);
/* Returns where a window's sliding must write its flags. Valid until the next call. The flags are kept only if
 * deform_wake_swept follows. */
struct place_flags deform_active_flags(struct deform *deform, const struct deform_window *window, uint32_t layer);
/* Returns the buffer that these flags are in. */
struct gpu_buffer *deform_active_words(const struct deform *deform);
/* Waits until all flags from the GPU have been read, then makes all blocks inactive. */
enum status deform_active_forget(struct deform *deform) FURROW_CHECKED;
/* Begins an interval: one round of sliding, which runs every few steps. Gives the blocks in which soil may still move. The list does
 * not change before deform_active_visited. */
enum status deform_active_visit(struct deform *deform, const struct soil_block_set **blocks) FURROW_CHECKED;
bool deform_active_is_visited(const struct deform *deform, struct soil_block block);
/* Returns the block's index in the list, and that of its word in the flags. */
uint32_t deform_active_word(const struct deform *deform, struct soil_block block);
/* Ends an interval. `flags`: a word for each block of the list: where soil still moves in it. */
enum status deform_active_visited(struct deform *deform, struct gpu_buffer *flags) FURROW_CHECKED;

/* interval.c */
enum status deform_interval_create(struct deform *deform) FURROW_CHECKED;
/* Prepares the interval's programs, as deform_warm does for contacts. */
enum status deform_interval_warm(struct deform *deform, const struct soil_shape *shape) FURROW_CHECKED;
void deform_interval_plan(const struct deform_params *params, struct plan *plan);
void deform_interval_destroy(struct deform *deform); /* does nothing if it was never created */

/* stages.c: deform_begin_layer: begins a window in its layer. deform_disturb: the pass that writes the disturbance of a window's posts. */
void deform_begin_layer(struct deform *deform, const struct deform_contact *contact, const struct deform_window *window, uint32_t layer);
enum status deform_disturb(struct deform *deform, struct post_rect read, uint32_t layer) FURROW_CHECKED;
/* stages.c: runs all passes over a window that was gathered. */
enum status deform_run_stages(struct deform *deform, const struct deform_contact *contact,
			      const struct deform_window *window, uint32_t layer) FURROW_CHECKED;

#endif
