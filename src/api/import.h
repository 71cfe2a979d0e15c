/* Imports elevation data into a store, for the command and for furrow_import. Any thread; one thread at a time uses an import. */
#ifndef FURROW_API_IMPORT_H
#define FURROW_API_IMPORT_H

#include "api/intake.h"
#include "dem/dem.h"
#include "store/store.h"

#define IMPORT_NODATA_MOST 32

/* api_import_init -> api_import_option ... -> api_import_open -> api_import_run -> api_import_finish */
struct import {
	struct dem_params dem;
	int64_t tile, jobs;
	double max_error; /* m; below 0: the default */
	double feather;   /* m; below 0: the default */
	bool match_heights;
	bool allow_network; /* dem_network_begin was called */
	char **inset_sources; /* owned; those that were named */
	size_t inset_count;
	enum store_pack pack;
	bool resume, overwrite, force;
	double nodata[IMPORT_NODATA_MOST];
	/* After api_import_open: */
	struct dem *opened;
	const char **inset_paths; /* of all insets, one inset after the other */
	struct dem_inset_source *inset_from;
	struct dem_insets *insets; /* NULL: there are none */
	double coarse_step; /* m: heights of the terrain are rounded to multiples of it; 0: they are stored as they come */
	struct store_meta meta; /* of the store that will be made */
	char *lines, *inset_lines, *description, *texts[6];
};

void api_import_init(struct import *import); /* sets all options to their defaults */
void api_import_finish(struct import *import);
/* Sets an option by the command's long name, with dashes or underlines. `value`: as the command takes it; of a switch "",
 * "true" or "false". `nodata` adds one value. STATUS_USAGE: there is no such option, or it does not take this value. */
enum status api_import_option(struct import *import, const char *name, const char *value) FURROW_CHECKED;
bool api_import_has_option(const char *name);
/* How an option takes a list. */
enum import_list {
	IMPORT_NO_LIST, /* it has one value */
	IMPORT_EACH,    /* a call of api_import_option for each value */
	IMPORT_JOINED   /* one call, with the values parted by commas */
};
enum import_list api_import_list(const char *name); /* IMPORT_NO_LIST of a name that is no option, too */
/* The values of `r`, `radii`, `pack` and `s-unit`, ended by NULL. */
extern const char *const api_import_methods[], *const api_import_radii[], *const api_import_packs[],
	*const api_import_units[];
/* Opens the sources, which must outlive the import. Writes nothing. STATUS_INPUT: they give no terrain. */
enum status api_import_open(struct import *import, const char *const *sources, size_t count) FURROW_CHECKED;
/* Makes the complete store, or none; fills `made`. STATUS_INTERRUPTED: `progress` stopped it. */
enum status api_import_run(struct import *import, const char *store, dem_progress_fn progress, void *user, struct intake *made) FURROW_CHECKED;

/* --- import_parts.c: parts of api_import_open --- */
enum status api_import_open_insets(struct import *import) FURROW_CHECKED; /* also sets the step, by the finest of all */
enum status api_import_describe(struct import *import) FURROW_CHECKED;    /* fills meta.sources and meta.request */

#endif
