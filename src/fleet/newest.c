/* Numbers of tiles, such as how high their ground is: each is taken from the rank that has the newest planes of its tile. */
#include "fleet/internal.h"

struct asking {
	const struct fleet *fleet;
	double *numbers;
	size_t count;
};

static enum status get_numbers(void *user, int rank, struct fleet_bytes *bytes)
{
	const struct asking *asking = user;
	uint32_t count;
	TRY(fleet_get(bytes, &count, sizeof count));
	for (uint32_t i = 0; i < count; i++) {
		uint32_t at;
		double number;
		TRY(fleet_get(bytes, &at, sizeof at));
		TRY(fleet_get(bytes, &number, sizeof number));
		if (at >= asking->count)
			return fail_with(STATUS_FAILED, "ranks: a number came for a tile that was not asked for; report this");
		if (rank != asking->fleet->rank)
			asking->numbers[at] = number;
	}
	return STATUS_OK;
}

/* Puts the numbers of the tiles that this rank changed last. A tile that no rank has changed is the same on all. */
static enum status put_numbers(struct fleet *fleet, size_t count, const uint64_t *keys, const double *numbers)
{
	uint32_t mine = 0;
	for (size_t i = 0; i < count; i++)
		mine += fleet_is_changed(fleet, keys[i]);
	TRY(fleet_begin(fleet, FLEET_NEWEST, STATUS_OK));
	TRY(fleet_put(&fleet->sent, &mine, sizeof mine));
	for (size_t i = 0; i < count; i++) {
		const uint32_t at = (uint32_t)i;
		if (!fleet_is_changed(fleet, keys[i]))
			continue;
		TRY(fleet_put(&fleet->sent, &at, sizeof at));
		TRY(fleet_put(&fleet->sent, &numbers[i], sizeof numbers[i]));
	}
	return STATUS_OK;
}

enum status fleet_newest(void *user, size_t count, const uint64_t *keys, double *numbers, enum status status)
{
	struct fleet *fleet = user;
	struct asking asking = {fleet, numbers, count};
	struct fleet_told told;
	if (fleet->failed)
		return status;
	if (status == STATUS_OK)
		status = put_numbers(fleet, count, keys, numbers);
	return fleet_tell(fleet, FLEET_NEWEST, status, &told, get_numbers, &asking);
}
