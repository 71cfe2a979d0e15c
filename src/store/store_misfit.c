/* Keeps in the store's header by how much its heights are off the sources. Sums are kept, so that a resumed import goes on with them. */
#include "store/internal.h"

#include <stdio.h>

static const char *const names[] = {"off_resampled", "off_source"};

static void key_of(int which, const char *part, char key[48])
{
	snprintf(key, 48, "%s_%s", names[which], part);
}

enum status store_misfit_write(struct store *store)
{
	const struct misfit *const both[] = {&store->meta.off_resampled, &store->meta.off_source};
	for (int i = 0; i < 2; i++) {
		char key[48];
		if (both[i]->posts == 0)
			continue;
		key_of(i, "posts", key);
		TRY(store_meta_put_integer(store, key, both[i]->posts));
		key_of(i, "greatest", key);
		TRY(store_meta_put_real(store, key, both[i]->greatest));
		key_of(i, "squares", key);
		TRY(store_meta_put_real(store, key, both[i]->squares));
	}
	return STATUS_OK;
}

enum status store_misfit_read(struct store *store)
{
	struct misfit *const both[] = {&store->meta.off_resampled, &store->meta.off_source};
	for (int i = 0; i < 2; i++) {
		char keys[3][48];
		key_of(i, "posts", keys[0]);
		key_of(i, "greatest", keys[1]);
		key_of(i, "squares", keys[2]);
		TRY(store_meta_misfit(store, keys[0], keys[1], keys[2], both[i]));
	}
	return STATUS_OK;
}

void store_put_holes(struct store *store, double share)
{
	store->meta.holes = share;
}

void store_put_misfit(struct store *store, const struct misfit *resampled, const struct misfit *source)
{
	misfit_add(&store->meta.off_resampled, resampled);
	misfit_add(&store->meta.off_source, source);
}
