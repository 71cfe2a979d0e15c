/*
 * exchange: the terrain in the formats of other tools. It writes tiles for web maps and globes, with a page that shows them, and
 * meshes of a window. No GL.
 *
 * Nothing here changes a store. Exports may run while a drive writes the store: each read sees one commit, two reads may see two.
 */
#ifndef FURROW_EXCHANGE_H
#define FURROW_EXCHANGE_H

#include <stdint.h>

#include "base/base.h"
#include "chart/chart.h"
#include "store/store.h"

/*
 * --- tiles (EXCHANGE.md has the files) ---
 *
 * A folder of tiles: terrain-RGB heights, hillshade and ruts as PNGs of 256 x 256 pixels under z/x/y, quantized-mesh tiles for
 * globes, layer.json, and index.html.
 */
struct exchange_tiles_params {
	struct store *store;
	const char *directory; /* made if it is not there */
	const char *title;     /* of the page */
	int64_t since;         /* write only tiles that changed after this revision; -1: all */
	bool has_range;
	double range[2];       /* metres: ends of the ruts' colours, below and above 0. Without it: chosen, or those of the folder */
	struct chart_sun sun;
	double exaggerate;     /* factor of heights for the shading */
	bool terrarium;        /* height tiles are coded as Terrarium's, in steps of 1/256 m; otherwise as Mapbox's, of 0.1 m */
	double step;           /* metres: height tiles are coded in steps of so much, from a zero of their own; 0: as `terrarium` says */
	int64_t pixels;        /* along a map tile: 256 or 512; 0: 256 */
	bool fine_globe;       /* globe tiles down to vertices no further apart than posts; otherwise than 1.41 posts */
	bool gzip;             /* globe tiles are compressed by gzip, under the same names */
	/* The part that is exported. Without a window: the whole. */
	bool has_window;
	double window[4];      /* metres east and north of the south-west post: west, south, east, north */
	bool has_clip;         /* and of the window only what lies within */
	double clip[4];        /* degrees: west, south, east, north */
	int64_t jobs;          /* threads; 0: one for each core */
	const char *leaflet;   /* folder of leaflet.js and leaflet.css, which are copied beside the page */
	/* Called on the caller's thread. If it does not return STATUS_OK, the work stops. May be NULL. */
	store_progress_fn progress;
	void *progress_user;
};

enum exchange_set { EXCHANGE_TERRAIN, EXCHANGE_HILLSHADE, EXCHANGE_RUTS, EXCHANGE_MESH, EXCHANGE_IMAGERY, EXCHANGE_SETS };

struct exchange_tiles_result {
	int64_t revision;                /* of the store, when the export began */
	char version[32];                /* of the tiles, in their urls: another one where the revision, the last run or the look is another */
	int zoom[2], mesh_zoom[2];       /* least and greatest */
	int imagery_zoom;                /* the greatest of imagery; -1: the store has none */
	double mesh_step[2];             /* metres between vertices to the east and to the north, at the finest mesh zoom that is complete */
	int64_t made[EXCHANGE_SETS];     /* tiles that were computed */
	int64_t written[EXCHANGE_SETS];  /* of these, files that are new or differ from what was there */
	int64_t removed;                 /* files of tiles that are no more */
	int64_t kept;                    /* blocks of tiles that an unfinished export had made */
	double range[2];                 /* metres: ends of the ruts' colours */
	double coding_zero;              /* metres: the least height that height tiles hold */
	bool local, earth;
	bool finer_left_out;             /* of one file: ruts or insets are finer than its zoom levels */
	char system[80];                 /* name of the degrees' system; "" for local metres */
	double seconds;
	int threads;
};

/*
 * Writes the tiles. If an export to the same folder with the same parameters and revision was killed, it goes on from there.
 * STATUS_INPUT: the folder holds something else, or tiles of another terrain, or tiles that are too old for `since`. STATUS_INPUT,
 * too: the code of height tiles cannot hold heights so great, or what is exported crosses the antimeridian or a pole. STATUS_FAILED: a file cannot be written; Leaflet is
 * not there. STATUS_INTERRUPTED: `progress` stopped it; the next call goes on.
 */
enum status exchange_tiles(const struct exchange_tiles_params *params, struct exchange_tiles_result *result) FURROW_CHECKED;

/*
 * Writes one set of map tiles, `set`, as an MBTiles file: params->directory is its path, and since and leaflet are not read. What is there is
 * replaced when the new file is complete. Of heights and hillshade it has the zoom levels that are complete. STATUS_INPUT: also where the store is local metres, which have no place on the world's map.
 */
enum status exchange_mbtiles(const struct exchange_tiles_params *params, enum exchange_set set, struct exchange_tiles_result *result) FURROW_CHECKED;

/*
 * --- meshes ---
 *
 * The surface of a window as triangles: two for each cell, one where one of its posts is a hole, none where more are. Positions
 * are metres east, north and up of the mesh's origin, so that floats hold them. A .glb has a picture over it, and a .obj the places in one.
 */
enum exchange_up { EXCHANGE_UP_FORMAT, EXCHANGE_UP_Y, EXCHANGE_UP_Z };
struct exchange_mesh_params {
	struct store_reader *reader;
	const struct store_meta *meta;
	const char *path;      /* ending in .obj, .glb or .stl */
	const char *name;      /* of the terrain, which .glb and .obj tell; NULL: "terrain" */
	/* EXCHANGE_UP_FORMAT: y in .glb and .obj, z in .stl. Where y is up, x is east and z south. A .glb takes no EXCHANGE_UP_Z */
	enum exchange_up up;
	bool deformed;         /* the store has a working level, `working`: the picture of a .glb may show ruts */
	int working;
	int level;
	struct post_rect rect; /* of posts of `level`, within the terrain */
	store_progress_fn progress; /* may be NULL */
	void *progress_user;
};
struct exchange_mesh_result {
	uint64_t vertices, triangles; /* STL has each vertex in each of its triangles */
	double origin[3]; /* metres: east and north of the store's south-west post, and height, where the mesh has (0, 0, 0) */
	double low[3], high[3]; /* metres: bounds of the positions, east, north, up */
	bool y_up;
};
/* Writes the mesh to another name first, then renames it. STATUS_INPUT: no triangle is there, or the file would be too large; the
 * message says how large. That counts holes as posts. STATUS_USAGE: another ending, or z is up in a .glb. */
enum status exchange_mesh(const struct exchange_mesh_params *params, struct exchange_mesh_result *result) FURROW_CHECKED;

#endif
