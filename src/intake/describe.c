/* Describes an import: what the store says about its sources, and all that decides its content. */
#include "intake/internal.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static size_t inset_count(const struct import *import)
{
	return import->insets != NULL ? dem_insets_count(import->insets) : 0;
}

/* Returns the sources, one a line; insets by their first. NULL: out of memory. */
static char *list_sources(const struct import *import)
{
	char *text = NULL;
	size_t size = 0;
	const struct dem_info *info = dem_info(import->opened);
	FILE *out = open_memstream(&text, &size);
	if (out == NULL)
		return NULL;
	for (size_t i = 0; i < info->source_count; i++)
		fprintf(out, "%s%s", i > 0 ? "\n" : "", info->sources[i]);
	for (size_t i = 0; i < inset_count(import); i++)
		for (size_t j = 0; j < dem_insets_files(import->insets, i)->source_count; j++)
			fprintf(out, "\n%s", dem_insets_files(import->insets, i)->sources[j]);
	const bool whole = ferror(out) == 0;
	if (fclose(out) == 0 && whole)
		return text;
	free(text);
	return NULL;
}

/* Returns the lines of store_meta.insets. NULL: out of memory. */
static char *tell_insets(const struct import *import)
{
	char *text = NULL, line[4400];
	size_t size = 0;
	FILE *out = open_memstream(&text, &size);
	if (out == NULL)
		return NULL;
	for (size_t i = 0; i < inset_count(import); i++) {
		const struct dem_inset_info *info = dem_insets_info(import->insets, i);
		const size_t length = strlen(info->source);
		(void)store_inset_line(&(struct store_inset){info->level, info->x, info->y, info->width, info->height, info->source,
							     length < 4096 ? length : 4096}, line, sizeof line);
		fputs(line, out);
	}
	const bool whole = ferror(out) == 0;
	if (fclose(out) == 0 && whole)
		return text;
	free(text);
	return NULL;
}

/* A raster that is a folder changes if a file of it does. */
static void describe_folder(FILE *out, const char *path, int depth)
{
	struct dirent **entries = NULL;
	const int count = depth < 16 ? scandir(path, &entries, NULL, alphasort) : 0;
	for (int i = 0; i < count; i++) {
		char full[4200];
		struct stat file = {0};
		const bool named = entries[i]->d_name[0] != '.' || entries[i]->d_name[1] == 'z';
		if (named && snprintf(full, sizeof full, "%s/%s", path, entries[i]->d_name) < (int)sizeof full && stat(full, &file) == 0) {
			fprintf(out, "%lld.%09ld %lld %s\n", (long long)file.st_mtim.tv_sec, (long)file.st_mtim.tv_nsec, (long long)file.st_size, full);
			if (S_ISDIR(file.st_mode))
				describe_folder(out, full, depth + 1);
		}
		free(entries[i]);
	}
	free(entries);
}

static void describe_file(FILE *out, const char *path)
{
	struct stat file = {0};
	char real[4200];
	const char *vsi = strncmp(path, "/vsi", 4) == 0 ? strchr(path + 1, '/') : NULL; /* /vsizip/a.zip/b.tif: a.zip */
	snprintf(real, sizeof real, "%s", vsi != NULL ? vsi + 1 : path);
	while (stat(real, &file) != 0 && vsi != NULL && strrchr(real, '/') != NULL && strrchr(real, '/') != real)
		*strrchr(real, '/') = '\0';
	if (S_ISDIR(file.st_mode))
		describe_folder(out, real, 0);
	fprintf(out, "%lld bytes of %lld.%09ld %s\n", (long long)file.st_size, (long long)file.st_mtim.tv_sec,
		(long)file.st_mtim.tv_nsec, path);
}

static void describe_files(FILE *out, const struct dem_info *info)
{
	for (size_t i = 0; i < info->source_count; i++)
		describe_file(out, info->sources[i]);
	for (size_t i = 0; i < info->file_count; i++)
		describe_file(out, info->files[i]);
}

/*
 * Returns a text with everything that decides the store's content, one fact a line. These are the options, and each source with
 * its files, their size and time of change. The program is one too, since the order of tiles and their bytes depend on it.
 * NULL: out of memory.
 */
static char *describe(const struct import *import, const struct dem_info *info)
{
	char *text = NULL;
	size_t size = 0;
	FILE *out = open_memstream(&text, &size);
	if (out == NULL)
		return NULL;
	const struct dem_params *dem = &import->dem;
	fputs("furrow " FURROW_VERSION "\n", out);
	fprintf(out, "posts %lld %lld tile %lld step %.17g pack %d spacing %.17g origin %.17g %.17g\n",
		(long long)info->width, (long long)info->height, (long long)import->tile, import->meta.step, (int)import->pack,
		info->spacing, info->origin[0], info->origin[1]);
	fprintf(out, "panel %lld resample %d radii %d fill %d range %d %.17g %.17g nodata", (long long)info->panel_posts,
		(int)dem->resample, (int)dem->radii, dem->fill, dem->has_height_range, dem->height_min, dem->height_max);
	for (size_t i = 0; i < dem->nodata_count; i++)
		fprintf(out, " %.17g", dem->nodata[i]);
	if (dem->band > 1 || dem->encoding != DEM_PLAIN)
		fprintf(out, " band %lld encoding %d", (long long)dem->band, (int)dem->encoding);
	fprintf(out, "\nsrs %s\nfrom %s\nvertical %s from %s to %s unit %s\n", info->srs, dem->s_srs != NULL ? dem->s_srs : "", info->vertical,
		dem->s_vertical != NULL ? dem->s_vertical : "", dem->t_vertical != NULL ? dem->t_vertical : "",
		dem->s_unit != NULL ? dem->s_unit : "");
	describe_files(out, info);
	if (inset_count(import) > 0)
		fprintf(out, "insets feather %.17g match %d coarse %.17g\n", import->feather, import->match_heights, import->coarse_step);
	for (size_t i = 0; i < inset_count(import); i++)
		describe_files(out, dem_insets_files(import->insets, i));
	bool whole = ferror(out) == 0;
	if (fclose(out) == 0 && whole)
		return text;
	free(text);
	return NULL;
}

enum status intake_import_describe(struct import *import)
{
	import->lines = list_sources(import);
	import->inset_lines = tell_insets(import);
	import->description = describe(import, dem_info(import->opened));
	TRY_MEM(import->lines != NULL && import->inset_lines != NULL && import->description != NULL, "sources");
	import->meta.sources = import->lines;
	import->meta.insets = import->inset_lines;
	import->meta.request = import->description;
	return STATUS_OK;
}
