/* SPDX-License-Identifier: MIT */
int lx_unit(int n);

int main(void)
{
    return lx_unit(1) != 2;
}
