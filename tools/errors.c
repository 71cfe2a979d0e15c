#include "errors.h"

#include <stdio.h>

/* Nothing was resampled if both compare the same posts with the same heights. */
static bool is_resampled(const struct store_meta *meta)
{
	const struct misfit *resampled = &meta->off_resampled, *source = &meta->off_source;
	return resampled->posts != source->posts || resampled->greatest != source->greatest || resampled->squares != source->squares;
}

void print_errors(const struct store_meta *meta, const char *first, const char *next)
{
	const struct misfit *resampled = &meta->off_resampled, *source = &meta->off_source;
	const char *what = is_resampled(meta) ? "the resampled source" : "the source";
	if (meta->max_error > 0)
		printf("%soff %s by at most %g m", first, what, meta->max_error);
	else
		printf("%slossless of %s", first, what);
	if (resampled->posts > 0 && meta->max_error > 0)
		printf("; measured: %.4g m, rms %.4g m", resampled->greatest, misfit_rms(resampled));
	putchar('\n');
	if (is_resampled(meta) && source->posts > 0)
		printf("%soff the source at its own %lld posts by at most %.4g m, rms %.4g m\n", next, (long long)source->posts,
		       source->greatest, misfit_rms(source));
	else if (is_resampled(meta))
		printf("%soff the source at its own posts: it has none on this ground\n", next);
}

void print_holes(const struct store_meta *meta, const char *first)
{
	if (meta->holes > 0)
		printf("%s%.3g %% of the posts\n", first, 100 * meta->holes);
}

static void misfit_json(cJSON *object, const char *name, const struct misfit *misfit)
{
	if (misfit->posts == 0) {
		cJSON_AddNullToObject(object, name);
		return;
	}
	cJSON *member = cJSON_AddObjectToObject(object, name);
	json_integer(member, "posts", misfit->posts);
	json_number(member, "greatest", misfit->greatest);
	json_number(member, "rms", misfit_rms(misfit));
}

void errors_json(cJSON *object, const struct store_meta *meta)
{
	json_number(object, "holes", meta->holes);
	json_number(object, "max_error", meta->max_error);
	misfit_json(object, "off_resampled", &meta->off_resampled);
	misfit_json(object, "off_source", &meta->off_source);
}
