/* The model `sumner` over whole sweeps: nothing is lost, whatever the ground, the object and the windows. */
#include "conserve.h"

static void every_quantum_stays(void **state)
{
	(void)state;
	need_gpu();
	conserve_every_quantum(DEFORM_SUMNER);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_quantum_stays),
	};
	return cmocka_run_group_tests_name("deform/sumner", tests, open_gpu, close_gpu);
}
